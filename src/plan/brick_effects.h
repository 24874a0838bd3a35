#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "atlas/atlas.h"
#include "scene/transfer_function.h"

namespace psivox {

inline double greatest_of(const glm::dvec3& color) { return std::max({color.x, color.y, color.z}); }

inline double greatest_of(const BrickAtlas& grid) {
  float most = 0;
  if (grid.channels == 1)
    for (const BrickStats& brick : grid.bricks) most = std::max(most, brick.max);
  else
    for (std::size_t i = 0; i < grid.texel_count(); ++i) most = std::max(most, grid.texels[i]);
  for (const float constant : grid.constants) most = std::max(most, constant);
  return double(most);
}

/// The greatest colour of any value.
inline double greatest_of(const TransferFunction& function) {
  constexpr double any = std::numeric_limits<double>::infinity();
  return greatest_of(function.max_color(-any, any));
}

/// How the attenuation varies over a brick's values.
struct FunctionBend {
  double slope = 1;        ///< largest
  double turn = 0;         ///< sum of the changes of slope inside the range
  double range = 0;        ///< largest minus smallest attenuation
  double most = 0;         ///< largest attenuation
  double color_slope = 0;  ///< largest, of any channel
};

/// A function's slopes, found once: a colour map has hundreds of knots, and a volume many bricks.
class FunctionBends {
 public:
  /// Null: the attenuation is the value.
  explicit FunctionBends(const TransferFunction* function) : function_(function) {
    if (!function) return;
    const std::vector<TransferPoint>& points = function->points();
    slopes_.resize(points.size() + 1);
    for (std::size_t k = 1; k < points.size(); ++k) {
      const TransferPoint &a = points[k - 1], &b = points[k];
      const double step = b.value - a.value;
      slopes_[k] = {(b.attenuation - a.attenuation) / step,
                    greatest_of(glm::abs(b.color - a.color)) / step};
    }
  }

  /// Between two values.
  FunctionBend between(double min, double max) const {
    if (!function_) return {.range = max - min, .most = max};
    FunctionBend bend{.slope = 0};
    double least = function_->attenuation(min);
    bend.most = std::max(least, function_->attenuation(max));
    least = std::min(least, function_->attenuation(max));
    const auto from = std::size_t(function_->interval(min) + 1);
    const auto to = std::size_t(function_->interval(max) + 1);
    for (std::size_t k = from; k <= to; ++k) {
      bend.slope = std::max(bend.slope, std::abs(slopes_[k].of_attenuation));
      bend.color_slope = std::max(bend.color_slope, slopes_[k].of_color);
      if (k == from) continue;
      bend.turn += std::abs(slopes_[k].of_attenuation - slopes_[k - 1].of_attenuation);
      const double knot = function_->points()[k - 1].attenuation;
      least = std::min(least, knot);
      bend.most = std::max(bend.most, knot);
    }
    bend.range = bend.most - least;
    return bend;
  }

 private:
  struct Slope {
    double of_attenuation = 0, of_color = 0;
  };
  const TransferFunction* function_;
  std::vector<Slope> slopes_;  ///< before each knot, and behind the last
};

}  // namespace psivox
