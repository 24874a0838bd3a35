#pragma once

#include <openvdb/openvdb.h>

#include <memory>

#include "vdb/grids_module.h"

namespace psivox::vdb {

/// Opens a .vdb. Throws Error(input).
std::unique_ptr<GridFile> open_vdb(std::shared_ptr<FileBlocks> file, Progress progress);

/// Opens a .nvdb. Throws Error(input) if it is damaged before its first grid, or of another major
/// version than psivox reads.
std::unique_ptr<GridFile> open_nano(std::shared_ptr<FileBlocks> file, Progress progress);

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

/// As GridsModule has them.
ConvertedGrid convert(FileGrid& grid, const ReadOptions& options);
FrustumPlace place(const Transform& frustum, const Box& active_box);

}  // namespace psivox::vdb
