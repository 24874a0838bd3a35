#pragma once

#include <openvdb/openvdb.h>

#include <string>

#include "grid_check.h"

namespace psivox::vdb {

/// Gives `value` to all that has the grid's background: its inactive voxels and tiles, and, unless
/// the value is 0, the rest of the active voxels' box. The background becomes 0. Returns what was
/// done, as the rest of a sentence. Throws std::runtime_error if the grid's type does not have the
/// value, or the box is too large to fill.
std::string take_background(openvdb::GridBase& grid, const GridSummary& summary, double value);

}  // namespace psivox::vdb
