#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <sstream>
#include <stdexcept>

#include "convert.h"

namespace psivox::vdb {
namespace {

using Grids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid,
                                openvdb::Int64Grid, openvdb::BoolGrid, openvdb::Vec3SGrid,
                                openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

/// Throws if the root of a grid's tree has nodes or tiles at places where none can be. OpenVDB
/// would compute ends beyond the integers from them.
void check_root(const openvdb::GridBase& grid) {
  grid.apply<Grids>([](const auto& typed) {
    const auto& root = typed.tree().root();
    constexpr int width = std::decay_t<decltype(root)>::ChildNodeType::DIM;
    for (auto it = root.cbeginChildAll(); it; ++it)
      if ((it.getCoord() & ~(width - 1)) != it.getCoord())
        throw std::runtime_error("a node of its root is at an impossible place");
  });
}

/// A file of grids that OpenVDB reads.
class OldFile : private openvdb::io::Archive {
 public:
  explicit OldFile(FileBlocks& file) : buffer_(file) {
    stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(stream_);
    // OpenVDB's readers ask the stream for these
    metadata_.reset(new openvdb::io::StreamMetadata);
    metadata_->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
  }

  openvdb::GridBase::Ptr read(const OldGrid& from) {
    const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(from.type);
    grid->setSaveFloatAsHalf(from.half);
    openvdb::io::GridDescriptor descriptor("", from.type, from.half);
    descriptor.setGridPos(from.begin);
    descriptor.setEndPos(from.end);
    stream_.clear();
    stream_.seekg(from.begin);
    buffer_.expect(from.end - from.begin);
    readGrid(grid, descriptor, stream_);
    check_root(*grid);
    return grid;
  }

  std::int64_t end_of_last() { return stream_.tellg(); }

 private:
  FileBuffer buffer_;
  std::istream stream_{&buffer_};              ///< throws where the file ends
  openvdb::io::StreamMetadata::Ptr metadata_;  ///< the stream keeps a plain pointer to it
};

}  // namespace

RewrittenGrid rewritten(FileBlocks& file, const OldGrid& grid, const OldGrid* parent) {
  OldFile old(file);
  const openvdb::GridBase::Ptr read = old.read(grid);
  const std::int64_t end = old.end_of_last();
  if (parent) read->setTree(old.read(*parent)->baseTreePtr());
  std::ostringstream out;
  openvdb::io::Stream stream(out);
  stream.setCompression(openvdb::io::COMPRESS_NONE);
  stream.write(openvdb::GridCPtrVec{read});
  return {std::move(out).str(), end};
}

}  // namespace psivox::vdb
