#pragma once

#include <optional>
#include <string>
#include <vector>

#include "psivox/draw.h"
#include "psivox/regions.h"

namespace psivox {

/// Which pictures can be drawn region by region, if this one cannot; else empty.
std::string region_obstacle(const View& view, const Wish& wish);
/// Which several processes can draw, if not this one; else empty.
std::string rank_obstacle(const View& view, const Wish& wish);

/// The regions by which a view must be drawn because its atlases, on host and GPU, take more than
/// its memory limit, or than four fifths of the memory that is free if it has none; unset if they
/// fit, or if only free memory is short and the picture cannot be drawn in parts. Other grids than
/// the density and its gradient stay whole. Throws Error(memory) if the limit cannot be kept.
/// `limit` stands for the scene's [bytes].
std::optional<Regions> needed_regions(const View& view, const Wish& wish,
                                      std::optional<double> limit = {});

/// The regions by which a rank draws its part of the volume, one or as many as memory asks for.
/// `bricks`: the density's. `local_ranks`: those that share the machine's memory, unless the scene
/// has a limit, which is each rank's. With light the part's values are in memory. Throws
/// Error(memory) if the limit cannot be kept.
Regions regions_of_part(const View& view, const Wish& wish, std::vector<glm::ivec3> bricks,
                        const Region& part, int local_ranks);

}  // namespace psivox
