#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>
#include <limits>
#include <string>

namespace psivox {

/// Numbers of replaced values. A tile counts as one voxel; each component of a vector counts.
struct BadValues {
  std::uint64_t nan = 0;
  std::uint64_t positive_infinite = 0;
  std::uint64_t negative_infinite = 0;
  std::uint64_t negative = 0;
  float largest = 1.0f;  ///< what +Inf became
  float least = 0.0f;    ///< of the negative values

  bool any() const { return nan + positive_infinite + negative_infinite + negative > 0; }

  /// `12 NaN, 3 negative values taken as 0`; it mentions +Inf only if there was one.
  std::string describe() const;
};

BadValues operator+(BadValues a, const BadValues& b);

/// Least and greatest of some values; +Inf, whose replacement is found last, is only noted.
struct Extent {
  float min = std::numeric_limits<float>::infinity();
  float max = -std::numeric_limits<float>::infinity();
  bool infinite = false;

  void add(float value) {
    if (std::isinf(value)) {
      infinite = true;
      return;
    }
    min = std::min(min, value);
    max = std::max(max, value);
  }
  glm::vec2 range(float largest) const {
    if (!infinite) return {min, max};
    return {std::min(min, largest), std::max(max, largest)};
  }
  Extent operator+(const Extent& other) const {
    return {std::min(min, other.min), std::max(max, other.max), infinite || other.infinite};
  }
};

/// What one pass over values of a grid finds out. Those of its parts add up.
struct ValueSurvey {
  BadValues bad;
  float largest = 0;  ///< finite value of any channel
  Extent all;         ///< first channel
  Extent active;      ///< of active voxels
  Extent in_box;      ///< of voxels in the box of active ones

  ValueSurvey operator+(const ValueSurvey& other) const {
    return {bad + other.bad, std::max(largest, other.largest), all + other.all,
            active + other.active, in_box + other.in_box};
  }
};

}  // namespace psivox
