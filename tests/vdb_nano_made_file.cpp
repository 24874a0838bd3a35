#include "vdb_nano_made_file.h"

#if __has_include(<nanovdb/tools/CreateNanoGrid.h>)
#include <nanovdb/tools/CreateNanoGrid.h>
using nanovdb::tools::openToNanoVDB;
#else
#include <nanovdb/util/OpenToNanoVDB.h>
using nanovdb::openToNanoVDB;
#endif

#include "scratch.h"
#include "vdb_test_util.h"

namespace psivox {

std::filesystem::path test::written_nano(const std::vector<openvdb::GridBase::Ptr>& grids,
                                         nanovdb::io::Codec codec, const std::string& name) {
  std::vector<nanovdb::GridHandle<>> handles;
  for (const openvdb::GridBase::Ptr& grid : grids) handles.push_back(openToNanoVDB(grid));
  const auto path = scratch_dir() / name;
  nanovdb::io::writeGrids(path.string(), handles, codec);
  return path;
}

}  // namespace psivox
