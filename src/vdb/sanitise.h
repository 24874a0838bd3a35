#pragma once

#include <cstddef>
#include <span>

#include "psivox/field.h"
#include "psivox/value_survey.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

inline constexpr std::size_t kLeafVoxels = 512;

/// Smallest value that stays.
float smallest_good(GridRole role);

/// Replaces NaN, -Inf and values below `smallest` of a leaf by 0, and counts them; +Inf is counted
/// and stays.
BadValues sanitise_leaf(float* values, int channels, float smallest);

/// Whether sanitise would leave the values as they are; `infinite`: +Inf counts as good.
bool all_good(std::span<const float> values, GridRole role, bool infinite = false);

/// Replaces NaN, -Inf and negative values by 0 and +Inf by the largest finite value of the grid (1
/// if there is none above 0). Under GridRole::data finite negative values stay. Tiles of value 0
/// are kept. Each leaf is 512 * channels floats. `elsewhere` is the largest finite value of leaves
/// that are not given.
BadValues sanitise(std::span<float* const> leaves, std::span<Tile> tiles, int channels,
                   GridRole role, float elsewhere = 0);

}  // namespace psivox::vdb
