#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

namespace psivox {

/// Ranges of values that stand side by side, so that compilers vectorise them.
template <std::size_t lanes>
struct LaneRange {
  std::array<float, lanes> low, high;

  LaneRange() {
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
  }
  /// Ranges from least to greatest, one a lane.
  void include(const float* least, const float* greatest) {
    for (std::size_t i = 0; i < lanes; ++i) low[i] = least[i] < low[i] ? least[i] : low[i];
    for (std::size_t i = 0; i < lanes; ++i) high[i] = high[i] < greatest[i] ? greatest[i] : high[i];
  }
  void include(const float* values) { include(values, values); }
  /// The least and greatest of some lanes.
  float least(std::size_t first = 0, std::size_t count = lanes) const {
    float value = low[first];
    for (std::size_t i = first; i < first + count; ++i) value = std::min(value, low[i]);
    return value;
  }
  float greatest(std::size_t first = 0, std::size_t count = lanes) const {
    float value = high[first];
    for (std::size_t i = first; i < first + count; ++i) value = std::max(value, high[i]);
    return value;
  }
};

}  // namespace psivox
