#pragma once

#include "vdb/grids_module.h"

namespace psivox::vdb {

/// As GridsModule has them.
ConvertedGrid convert(FileGrid& grid, const ReadOptions& options);
FrustumPlace place(const Transform& frustum, const Box& active_box);

}  // namespace psivox::vdb
