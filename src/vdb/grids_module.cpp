#include "grids_module.h"

#include "base/loaded_module.h"
#include "psivox/error.h"

namespace psivox::vdb {
namespace {

struct LoadedModule {
  const GridsModule* grids = nullptr;
  std::string problem;
};

LoadedModule load() {
  LoadedModule module;
  const auto get = reinterpret_cast<GetGridsModule>(
      load_symbol(PSIVOX_READER_MODULE, grids_symbol, /*shared=*/false, module.problem));
  if (get) module.grids = get();
  return module;
}

}  // namespace

bool begins(FileBlocks& file, std::string_view magic) {
  const FileRun first = file.run(0);
  return std::string_view(first.bytes.get(), std::size_t(first.size)).starts_with(magic);
}

bool has_grids(FileBlocks& file) { return begins(file, vdb_magic) || begins(file, nano_magic); }

const GridsModule& grids_module() {
  static const LoadedModule loaded = load();
  if (loaded.grids) return *loaded.grids;
  throw Error(ExitCode::failure, "cannot load the module with OpenVDB: " + loaded.problem);
}

}  // namespace psivox::vdb
