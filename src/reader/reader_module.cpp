// The module psivox_reader: files of grids, read by OpenVDB and NanoVDB.

#include <openvdb/openvdb.h>
#include <openvdb/points/AttributeArray.h>

#include <utility>

#include "archives.h"
#include "grid_types.h"

namespace psivox::vdb {
namespace {

std::unique_ptr<GridFile> open(std::shared_ptr<FileBlocks> file, Progress progress) {
#ifdef PSIVOX_NANOVDB
  if (begins(*file, nano_magic)) return open_nano(std::move(file), std::move(progress));
#else
  if (begins(*file, nano_magic))
    throw Error(ExitCode::input, subject(file->path()) +
                                     "is a NanoVDB file, and this psivox was built without "
                                     "PSIVOX_NANOVDB");
#endif
  return open_vdb(std::move(file), std::move(progress));
}

constexpr GridsModule module = {openvdb::getLibraryVersionString, open, convert, place};

}  // namespace
}  // namespace psivox::vdb

extern "C" const psivox::vdb::GridsModule* psivox_reader() {
  using openvdb::points::TypedAttributeArray, openvdb::points::TruncateCodec;
  using psivox::vdb::HalfGrid;
  openvdb::initialize();
  // what files have and OpenVDB may not register
  if (!HalfGrid::isRegistered()) HalfGrid::registerGrid();
  using Truncated = TypedAttributeArray<std::int32_t, TruncateCodec>;
  if (!Truncated::isRegistered()) Truncated::registerType();
  return &psivox::vdb::module;
}
