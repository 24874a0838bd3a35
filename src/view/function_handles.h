#pragma once

#include <algorithm>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

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

using TransferPoints = std::vector<TransferPoint>;

/// The points with their values stretched so that the first is `low` and the last `high`.
TransferPoints stretched(TransferPoints points, double low, double high);
/// The points with their attenuations scaled so that the greatest is `most`.
TransferPoints scaled(TransferPoints points, double most);

/// Handles beside the canvas of a transfer function. They change all points at once: the ends of
/// the range and the bar between them below the canvas, the opacity on its right.
class FunctionHandles {
 public:
  enum class Handle { low, high, range, opacity };

  /// Side of a handle [pixels].
  static double size();
  /// Draws the strip below the canvas, then the one beside it. Returns the points as dragged.
  std::optional<TransferPoints> draw(const FunctionCanvas& canvas, const TransferPoints& points);
  bool dragging() const { return dragged_.has_value(); }

  /// Where the window shows a handle [pixels].
  static glm::dvec2 place_of(Handle handle, const FunctionCanvas& canvas,
                             const TransferPoints& points);

 private:
  std::optional<Handle> pressed(const FunctionCanvas& canvas, const TransferPoints& points) const;
  TransferPoints moved(const FunctionCanvas& canvas, const glm::dvec2& mouse) const;

  std::optional<Handle> dragged_;
  glm::dvec2 from_{0};    ///< where the drag began [pixels]
  TransferPoints begun_;  ///< before the drag
};

}  // namespace psivox::view
