#pragma once

#include "grid_file.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// The row of one grid; reads its tree, without `values` only its topology. Never throws for a bad
/// grid: GridInfo::problem says why.
GridInfo grid_info(GridFile& file, const GridEntry& entry, bool values);

/// What a picture could be made of. It reads the topology, and leaves up to the first that has an
/// active value other than 0. Throws Error(input).
GridContent content_of(GridFile& file, const GridEntry& entry);

/// What a picture could be made of a grid with so many active voxels, some of which are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

}  // namespace psivox::vdb
