#pragma once

#include <memory>

#include "vdb/grids_module.h"

namespace psivox::vdb {

/// Opens a .vdb. Throws Error(input).
std::unique_ptr<GridFile> open_vdb(std::shared_ptr<FileBlocks> file, Progress progress);

/// Opens a .nvdb. Throws Error(input) if it is damaged before its first grid, or of another major
/// version than psivox reads.
std::unique_ptr<GridFile> open_nano(std::shared_ptr<FileBlocks> file, Progress progress);

/// As GridsModule has them.
ConvertedGrid convert(FileGrid& grid, const ReadOptions& options);
FrustumPlace place(const Transform& frustum, const Box& active_box);

}  // namespace psivox::vdb
