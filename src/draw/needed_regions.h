#pragma once

#include <optional>

#include "psivox/draw.h"
#include "psivox/regions.h"

namespace psivox {

/// The regions by which a view must be drawn because its atlases, on host and GPU, take more than
/// its memory limit, or than four fifths of the memory that is free if it has none; unset if they
/// fit, or if only free memory is short and the picture cannot be drawn in parts. Other grids than
/// the density and its gradient stay whole. Throws Error(memory) if the limit cannot be kept.
/// `limit` stands for the scene's [bytes].
std::optional<Regions> needed_regions(const View& view, const Wish& wish,
                                      std::optional<double> limit = {});

}  // namespace psivox
