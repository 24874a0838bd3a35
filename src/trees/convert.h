#pragma once

#include <string>

#include "vdb/trees.h"

namespace psivox::vdb {

// Functions of Trees.
ConvertedGrid convert(const TreeSource& from, const ReadOptions& options);
FrustumPlace place(const std::string& bytes, const Box& active_box);
RewrittenGrid rewritten(FileBlocks& file, const OldGrid& grid, const OldGrid* parent);

}  // namespace psivox::vdb
