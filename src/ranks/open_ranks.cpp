#include <unistd.h>

#include <cstdlib>
#include <string>

#include "psivox/loaded_module.h"
#include "psivox/ranks.h"
#include "psivox/text.h"
#include "ranks/rank_module.h"

namespace psivox {
namespace {

/// What the environment says of how this process was started.
struct Launch {
  int count = 1;  ///< ranks; 0: not said
  int rank = 0;
  std::vector<std::string> modules;  ///< by preference
};

int number_of(const char* name, int if_unset) {
  const char* text = std::getenv(name);
  return text && *text ? std::atoi(text) : if_unset;
}

Launch find_launch() {
  const std::string openmpi = "openmpi", mpich = "mpich";
  if (const int count = number_of("OMPI_COMM_WORLD_SIZE", -1); count >= 0)
    return {count, number_of("OMPI_COMM_WORLD_RANK", 0), {openmpi}};
  if (const int count = number_of("PMI_SIZE", -1); count >= 0)
    return {count, number_of("PMI_RANK", 0), {mpich, openmpi}};
  if (const int rank = number_of("PMIX_RANK", -1); rank >= 0)
    return {number_of("SLURM_STEP_NUM_TASKS", 0), rank, {openmpi, mpich}};
  return {};
}

std::shared_ptr<Ranks> load(const Launch& launch) {
  std::string problems;
  for (const std::string& name : launch.modules) {
    std::string problem;
    const auto open = reinterpret_cast<OpenRanks>(
        load_symbol(rank_module(name), open_ranks_symbol, /*shared=*/true, problem));
    if (open) return std::shared_ptr<Ranks>(open());
    problems += (problems.empty() ? "" : "; ") + problem;
  }
  // mpirun ends all when one ends: the first rank has a second to tell why
  if (launch.rank != 0) {
    sleep(1);
    _exit(static_cast<int>(ExitCode::failure));
  }
  throw Error(ExitCode::failure,
              "this is one of several processes of MPI, which would each draw the same picture, "
              "and psivox has no module for that MPI (" +
                  problems +
                  "); build psivox with it, or start one process, or set PSIVOX_MPI=none");
}

}  // namespace

std::shared_ptr<Ranks> open_ranks() {
  Launch launch = find_launch();
  const char* wanted = std::getenv("PSIVOX_MPI");
  if (wanted && *wanted) {
    if (std::string(wanted) == "none") return nullptr;
    if (std::string(wanted) != "openmpi" && std::string(wanted) != "mpich")
      throw Error(ExitCode::usage,
                  "PSIVOX_MPI is " + in_quotes(wanted) + "; it can be openmpi, mpich or none");
    launch.modules = {wanted};
  }
  if (launch.count == 1) return nullptr;
  std::shared_ptr<Ranks> ranks = load(launch);
  if (launch.count > 0 && ranks->count() != launch.count) {
    if (launch.rank == 0)
      throw Error(ExitCode::failure, "psivox was started as " + std::to_string(launch.count) +
                                         " processes, of which its MPI knows " +
                                         std::to_string(ranks->count()) +
                                         "; set PSIVOX_MPI to the MPI of the launcher: openmpi or "
                                         "mpich");
    ranks->finish();
    sleep(1);
    _exit(static_cast<int>(ExitCode::failure));
  }
  if (ranks->count() == 1) {
    ranks->finish();
    return nullptr;
  }
  static std::shared_ptr<Ranks> last;
  last = ranks;
  std::atexit([] { last->finish(); });
  try {
    ranks->check_same(PSIVOX_VERSION, "has another version of psivox");
  } catch (const AgreedError& error) {
    if (!ranks->first()) std::exit(static_cast<int>(error.code()));
    throw;
  }
  return ranks;
}

}  // namespace psivox
