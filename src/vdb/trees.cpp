#include "trees.h"

#include <mutex>
#include <optional>

#include "base/loaded_module.h"
#include "psivox/error.h"

namespace psivox::vdb {
namespace {

struct LoadedTrees {
  const Trees* trees = nullptr;
  std::string problem;
};

std::optional<LoadedTrees> loaded;  ///< once that was tried
std::mutex mutex;                   ///< of it
bool may_load = true;

LoadedTrees load() {
  LoadedTrees module;
  const auto get = reinterpret_cast<GetTrees>(
      load_symbol(PSIVOX_TREES_MODULE, trees_symbol, /*shared=*/false, module.problem));
  if (get) module.trees = get();
  return module;
}

}  // namespace

const Trees& trees() {
  const std::lock_guard lock(mutex);
  if (!loaded && !may_load) throw TreesNeeded();
  if (!loaded) loaded = load();
  if (loaded->trees) return *loaded->trees;
  throw Error(ExitCode::failure, "cannot load the module with OpenVDB: " + loaded->problem);
}

void load_no_trees() { may_load = false; }

}  // namespace psivox::vdb
