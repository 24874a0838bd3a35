#pragma once

#include <openvdb/openvdb.h>

#include <memory>

#include "vdb/grid_file.h"

namespace psivox::vdb {

/// A grid of a .vdb whose metadata, transform and topology OpenVDB has read. Its leaves have no
/// values yet.
struct VdbSource {
  const GridFile& file;
  const GridEntry& entry;
  bool marked;  ///< see GridFile::open
  GridHead head;
  openvdb::GridBase::Ptr grid;              ///< with the tree
  openvdb::io::StreamMetadata::Ptr coding;  ///< how its leaves are stored
  std::shared_ptr<FileBlocks> blocks;
  std::istream& stream;  ///< at the values of the first leaf; has `coding`
  FileBuffer& buffer;    ///< of the stream
};

/// Throws std::runtime_error if the tree is damaged.
std::unique_ptr<FileGrid> vdb_grid(const VdbSource& source);

}  // namespace psivox::vdb
