#pragma once

#include "archive.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// The row of one grid; reads its tree, without `values` only its topology. Never throws for a bad
/// grid: GridInfo::problem says why.
GridInfo grid_info(Archive& archive, const GridEntry& entry, bool values);

}  // namespace psivox::vdb
