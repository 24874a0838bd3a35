#pragma once

#include "archive.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// The row of one grid; reads its tree. Never throws for a bad grid: GridInfo::problem says why.
GridInfo grid_info(Archive& archive, const GridEntry& entry);

}  // namespace psivox::vdb
