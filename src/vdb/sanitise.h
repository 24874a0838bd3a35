#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "psivox/field.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

inline constexpr std::size_t kLeafVoxels = 512;

/// Numbers of replaced values. A tile counts as one voxel; each component of a vector counts.
struct BadValues {
  std::uint64_t nan = 0;
  std::uint64_t positive_infinite = 0;
  std::uint64_t negative_infinite = 0;
  std::uint64_t negative = 0;
  float largest = 1.0f;  ///< what +Inf became

  bool any() const { return nan + positive_infinite + negative_infinite + negative > 0; }

  /// `12 NaN, 3 negative values taken as 0`; it mentions +Inf only if there was one.
  std::string describe() const;
};

BadValues operator+(BadValues a, const BadValues& b);

/// Smallest value that stays.
float smallest_good(GridRole role);

/// Replaces NaN, -Inf and values below `smallest` of a leaf by 0, and counts them; +Inf is counted
/// and stays.
BadValues sanitise_leaf(float* values, int channels, float smallest);

/// Whether sanitise would leave the values as they are.
bool all_good(std::span<const float> values, GridRole role);

/// Replaces NaN, -Inf and negative values by 0 and +Inf by the largest finite value of the grid (1
/// if there is none above 0). Under GridRole::data finite negative values stay. Tiles of value 0
/// are kept. Each leaf is 512 * channels floats. `elsewhere` is the largest finite value of leaves
/// that are not given.
BadValues sanitise(std::span<float* const> leaves, std::span<Tile> tiles, int channels,
                   GridRole role, float elsewhere = 0);

}  // namespace psivox::vdb
