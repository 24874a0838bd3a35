#pragma once

#include <algorithm>
#include <glm/vec2.hpp>

#include "psivox/transfer_function.h"

namespace psivox::view {

/// Where a transfer function is drawn: values from left to right, attenuation from bottom to top.
struct FunctionCanvas {
  glm::dvec2 corner{0}, size{0};      ///< of the window [pixels]
  double low = 0, high = 1, top = 1;  ///< values at the left and right, attenuation at the top

  glm::dvec2 pixel_of(const TransferPoint& point) const {
    return corner +
           size * glm::dvec2((point.value - low) / (high - low), 1 - point.attenuation / top);
  }
  double value_at(double x) const {
    return low + std::clamp((x - corner.x) / size.x, 0.0, 1.0) * (high - low);
  }
  /// Above the top too.
  double attenuation_at(double y) const { return std::max(1 - (y - corner.y) / size.y, 0.0) * top; }
  TransferPoint point_at(const glm::dvec2& pixel) const {
    TransferPoint point;
    point.value = value_at(pixel.x);
    point.attenuation = std::min(attenuation_at(pixel.y), top);
    return point;
  }
};

}  // namespace psivox::view
