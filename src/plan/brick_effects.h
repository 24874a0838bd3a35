#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <vector>

#include "march/medium_atlas.h"
#include "scene/transfer_function.h"

namespace psivox {

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
  explicit FunctionBends(const TransferFunction& function) : function_(function) {
    const std::vector<TransferPoint>& points = function.points();
    for (std::size_t k = 0; k <= points.size(); ++k) {
      double slope = 0;  // between the knots k - 1 and k
      if (k > 0 && k < points.size())
        slope = (points[k].attenuation - points[k - 1].attenuation) /
                (points[k].value - points[k - 1].value);
      color_slopes_.push_back(k > 0 && k < points.size() ? color_slope(points[k - 1], points[k])
                                                         : 0);
      turns_.push_back(k > 0 ? std::abs(slope - slopes_.back()) : 0);
      slopes_.push_back(slope);
    }
  }

  /// Between two values.
  FunctionBend between(double min, double max) const {
    FunctionBend bend{.slope = 0};
    double least = function_.attenuation(min), most = least;
    const auto see = [&](double value) {
      least = std::min(least, value);
      most = std::max(most, value);
    };
    see(function_.attenuation(max));
    const int from = function_.interval(min), to = function_.interval(max);
    for (int k = from; k <= to; ++k) {
      bend.slope = std::max(bend.slope, std::abs(slopes_[std::size_t(k + 1)]));
      bend.color_slope = std::max(bend.color_slope, color_slopes_[std::size_t(k + 1)]);
      if (k == from) continue;
      bend.turn += turns_[std::size_t(k + 1)];
      see(function_.points()[std::size_t(k)].attenuation);
    }
    bend.range = most - least;
    bend.most = most;
    return bend;
  }

 private:
  static double color_slope(const TransferPoint& a, const TransferPoint& b) {
    const glm::dvec3 change = glm::abs(b.color - a.color) / (b.value - a.value);
    return std::max({change.x, change.y, change.z});
  }

  const TransferFunction& function_;
  std::vector<double> slopes_;        ///< before each knot, and behind the last
  std::vector<double> color_slopes_;  ///< the same of the colours
  std::vector<double> turns_;         ///< changes of the slope at the knots; first 0
};

inline double greatest_of(const glm::dvec3& color) { return std::max({color.x, color.y, color.z}); }

inline float greatest_of(const BrickAtlas& grid) {
  float most = 0;
  if (grid.channels == 1)
    for (const BrickStats& brick : grid.bricks) most = std::max(most, brick.max);
  else
    for (std::size_t i = 0; i < grid.texel_count(); ++i) most = std::max(most, grid.texels[i]);
  for (const float constant : grid.constants) most = std::max(most, constant);
  return most;
}

/// Largest luminance of the medium for densities between two values.
class Peak {
 public:
  Peak(const View& view, const MediumAtlas& atlas) : medium_(view.medium) {
    if (atlas.luminance) factor_ = double(greatest_of(*atlas.luminance));
  }
  double at(double min, double max) const {
    double peak = greatest_of(medium_.color) * factor_;
    if (medium_.source == LuminanceSource::density) peak *= max;
    if (has_colors()) peak *= greatest_of(medium_.transfer->max_color(min, max));
    return peak + greatest_of(medium_.ambient);
  }

  bool depends_on_value() const {
    return medium_.source == LuminanceSource::density || has_colors();
  }

 private:
  bool has_colors() const {
    return medium_.source == LuminanceSource::transfer || medium_.lit_colors;
  }

  const Medium& medium_;
  double factor_ = 1;
};

}  // namespace psivox
