#pragma once

#include <optional>
#include <vector>

#include "view/function_canvas.h"

namespace psivox::view {

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
