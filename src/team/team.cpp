#include "psivox/team.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <new>

#include "base/loaded_module.h"
#include "base/text.h"

namespace psivox {
namespace {

/// What all_gather sends: content, or an exit code, a machine's name, a line's end and a message.
constexpr char content = 'c', failure = 'f';

/// A module's one symbol (src/team/mpi). There is one module for each MPI that the build found, so
/// that libpsivox needs none, and one build runs under both.
constexpr const char* open_team_symbol = "psivox_open_team";
using OpenTeam = Team* (*)();
/// The file of the module for an MPI: `openmpi` or `mpich`.
std::string team_module(const std::string& mpi) { return "libpsivox_" + mpi + ".so"; }

/// Nothing is sent, and nobody waits for reports.
class Alone final : public Team {
 public:
  Alone() : Team(Place{}) {}
  void report(double) override {}
  Reported reported() override { return {1, 1}; }
  void abort(int code) override { std::_Exit(code); }
  void finish() override {}

 protected:
  std::vector<std::string> all_gather(const std::string& bytes) override { return {bytes}; }
  void all_exchange(const std::vector<Bytes>& to, std::size_t, const Received& received) override {
    std::ranges::copy(to[0], received(0, to[0].size()));
  }
};

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

std::shared_ptr<Team> load_team(const Launch& launch) {
  std::string problems;
  for (const std::string& name : launch.modules) {
    std::string problem;
    const auto open = reinterpret_cast<OpenTeam>(
        load_symbol(team_module(name), open_team_symbol, /*shared=*/true, problem));
    if (open) return std::shared_ptr<Team>(open());
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

std::vector<std::string> Team::checked(std::vector<std::string> messages) const {
  const auto failed = [](const std::string& message) { return message[0] == failure; };
  const auto first = std::ranges::find_if(messages, failed);
  if (first == messages.end()) {
    for (std::string& message : messages) message.erase(0, 1);
    return messages;
  }
  const auto line_end = first->find('\n');
  std::string text = first->substr(line_end + 1);
  // what only some ranks met may be their machine's
  if (!std::ranges::all_of(messages, failed))
    text = "rank " + std::to_string(first - messages.begin()) + " of " + std::to_string(size()) +
           ", on " + first->substr(2, line_end - 2) + ": " + text;
  throw AgreedError(static_cast<ExitCode>((*first)[1]), text);
}

std::vector<std::string> Team::gather(std::string_view bytes) {
  if (size() == 1) return {std::string(bytes)};
  return checked(all_gather(content + std::string(bytes)));
}

void Team::check_same(std::string_view bytes, const std::string& differs) {
  const std::vector<std::string> all = gather(bytes);
  for (std::size_t rank = 1; rank < all.size(); ++rank)
    if (all[rank] != all[0])
      throw AgreedError(ExitCode::input,
                        "rank " + std::to_string(rank) + " " + differs + " than rank 0");
}

void Team::agree(const std::function<void()>& work) {
  if (size() == 1) return work();
  std::string message(1, content);
  const auto fail = [&](ExitCode code, const std::string& what) {
    message = failure + std::string(1, static_cast<char>(code)) + place_.machine + "\n" + what;
  };
  try {
    work();
  } catch (const AgreedError&) {
    throw;
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    fail(ExitCode::memory, "out of memory; start more ranks, or set --memory-limit");
  } catch (const std::exception& error) {
    fail(ExitCode::failure, error.what());
  }
  checked(all_gather(message));
}

const std::shared_ptr<Team>& alone() {
  static const std::shared_ptr<Team> team = std::make_shared<Alone>();
  return team;
}

std::shared_ptr<Team> open_team() {
  Launch launch = find_launch();
  const char* wanted = std::getenv("PSIVOX_MPI");
  if (wanted && *wanted) {
    if (std::string(wanted) == "none") return alone();
    if (std::string(wanted) != "openmpi" && std::string(wanted) != "mpich")
      throw Error(ExitCode::usage,
                  "PSIVOX_MPI is " + in_quotes(wanted) + "; it can be openmpi, mpich or none");
    launch.modules = {wanted};
  }
  if (launch.count == 1) return alone();
  std::shared_ptr<Team> team = load_team(launch);
  if (launch.count > 0 && team->size() != launch.count) {
    if (launch.rank == 0)
      throw Error(ExitCode::failure, "psivox was started as " + std::to_string(launch.count) +
                                         " processes, of which its MPI knows " +
                                         std::to_string(team->size()) +
                                         "; set PSIVOX_MPI to the MPI of the launcher: openmpi or "
                                         "mpich");
    team->finish();
    sleep(1);
    _exit(static_cast<int>(ExitCode::failure));
  }
  if (team->size() == 1) {
    team->finish();
    return alone();
  }
  static std::shared_ptr<Team> last;
  last = team;
  std::atexit([] { last->finish(); });
  try {
    team->check_same(PSIVOX_VERSION, "has another version of psivox");
  } catch (const AgreedError& error) {
    if (!team->first()) std::exit(static_cast<int>(error.code()));
    throw;
  }
  return team;
}

}  // namespace psivox
