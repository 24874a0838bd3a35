#include "plan/step_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "field/index_space.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Smallest fraction of a step; below that, cells are cheaper.
constexpr double least_part = 1.0 / 4096;

/// Number of kinks that one ray may meet in a brick with errors of the same sign, divided by the 8
/// of h^2/8, which is what a trapezoid misses at one kink. From the pictures of
/// psivox_bench_tolerance: the bound exceeds their largest errors.
constexpr double kinks_share = 4.0 / 8;

/// The share for emission, which lattices are tried with in the middle of a step.
constexpr double emission_kinks_share = 4.0 / 8;

/// How the attenuation varies over a brick's values.
struct FunctionBend {
  double slope = 1;  ///< largest
  double turn = 0;   ///< sum of the changes of slope inside the range
  double range = 0;  ///< largest minus smallest attenuation
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
      turns_.push_back(k > 0 ? std::abs(slope - slopes_.back()) : 0);
      slopes_.push_back(slope);
    }
  }

  /// Between two values.
  FunctionBend between(double min, double max) const {
    FunctionBend bend{0, 0, 0};
    double least = function_.at(min).attenuation, most = least;
    const auto see = [&](double value) {
      least = std::min(least, value);
      most = std::max(most, value);
    };
    see(function_.at(max).attenuation);
    const int from = function_.interval(min), to = function_.interval(max);
    for (int k = from; k <= to; ++k) {
      bend.slope = std::max(bend.slope, std::abs(slopes_[std::size_t(k + 1)]));
      if (k == from) continue;
      bend.turn += turns_[std::size_t(k + 1)];
      see(function_.points()[std::size_t(k)].attenuation);
    }
    bend.range = most - least;
    return bend;
  }

 private:
  const TransferFunction& function_;
  std::vector<double> slopes_;  ///< before each knot, and behind the last
  std::vector<double> turns_;   ///< changes of the slope at the knots; first 0
};

/// Most that a brick's values change along a unit of length of any direction [1/voxel].
double greatest_slope(const float* values) {
  constexpr std::size_t n = brick_values;
  double sum = 0;
  for (const std::size_t along : {n * n, n, std::size_t{1}}) {
    float most = 0;
    for (std::size_t first = 0; first < brick_texels; first += n * along)
      for (std::size_t at = first + along; at < first + n * along; ++at)
        most = std::max(most, std::abs(values[at] - values[at - along]));
    sum += double(most) * double(most);
  }
  return std::sqrt(sum);
}

float greatest_of(const BrickAtlas& grid) {
  float most = 0;
  if (grid.channels == 1)
    for (const BrickStats& brick : grid.bricks) most = std::max(most, brick.max);
  else
    for (std::size_t i = 0; i < grid.texel_count(); ++i) most = std::max(most, grid.texels32[i]);
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
    double peak = std::max({medium_.color.x, medium_.color.y, medium_.color.z}) * factor_;
    if (medium_.source == LuminanceSource::density) peak *= max;
    if (medium_.source == LuminanceSource::transfer) {
      const glm::dvec3 color = medium_.transfer->max_color(min, max);
      peak *= std::max({color.x, color.y, color.z});
    }
    const glm::dvec3& ambient = medium_.ambient;
    return peak + std::max({ambient.x, ambient.y, ambient.z});
  }

 private:
  const Medium& medium_;
  double factor_ = 1;
};

}  // namespace

StepBounds::StepBounds(const View& view, const MediumAtlas& atlas, double brightest)
    : density_(atlas.density), bounds_(atlas.density.bricks.size()) {
  const Medium& medium = view.medium;
  const std::vector<BrickStats>& bricks = atlas.density.bricks;
  const Peak peak(view, atlas);
  const double scale = medium.extinction * finest_voxel(*medium.density);
  kink_scale_ = scale * kinks_share;
  const double floor = std::max(1.0, brightest);
  double least = 0, most = 0;
  for (const BrickStats& brick : bricks) {
    least = std::min(least, double(brick.min));
    most = std::max(most, double(brick.max));
  }
  const double highest = peak.at(least, most);  // of any brick
  std::optional<FunctionBends> bends;
  if (medium.transfer) bends.emplace(*medium.transfer);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double min = bricks[i].min, max = bricks[i].max, range = max - min;
    FunctionBend bend{1, 0, range};
    if (bends) bend = bends->between(min, max);
    if (medium.gradient) {
      bend.range = medium.transfer->max_attenuation({min, max}, {0.0, 1e38});
      bend.turn = 1e38;
    }
    Bound& bound = bounds_[i];
    bound.effect = std::max(floor, highest > floor ? peak.at(min, max) : 0);
    bound.first = scale * bend.range / 2;
    bound.slope = bend.slope;
    bound.turn = bend.turn;
    bound.second = kink_scale_ * bend.slope * double(bricks[i].second_difference);
  }
  if (atlas.emission) bound_emission(view, *atlas.emission);
}

void StepBounds::complete(const std::vector<bool>& wanted) {
  const std::vector<float> kinks = brick_kinks(density_, wanted);
  tbb::parallel_for(std::size_t{0}, kinks.size(), [&](std::size_t i) {
    if (!wanted[i]) return;
    Bound& bound = bounds_[i];
    // where the function bends, the attenuation's slope changes by the slope of the
    // values times the bend
    double steepest = double(density_.bricks[i].max) - double(density_.bricks[i].min);
    if (bound.turn > 0)
      steepest = std::min(steepest, greatest_slope(density_.texels32.get() + i * brick_texels));
    bound.second = kink_scale_ * (bound.slope * double(kinks[i]) + bound.turn * steepest);
    bound.complete = true;
  });
}

void StepBounds::bound_emission(const View& view, const BrickAtlas& emission) {
  const Medium& medium = view.medium;
  const std::vector<float> kinks = brick_kinks(emission);
  const double unit = finest_voxel(*medium.density);
  const double voxels = unit / finest_voxel(*medium.emission);  // of the emission a step of 1
  const double scale = medium.emission_scale * unit;
  const std::size_t stride = std::size_t(emission.channels) * brick_texels;
  for (std::size_t i = 0; i < kinks.size(); ++i) {
    const float* values = emission.texels32.get() + i * stride;
    const auto [least, most] = std::minmax_element(values, values + stride);
    emission_.push_back(
        {scale * double(*most - *least), scale * voxels * emission_kinks_share * double(kinks[i])});
  }
}

double StepBounds::Bound::step(double depth) const {
  return std::max(first > 0 ? depth / first : 1e30, second > 0 ? std::sqrt(depth / second) : 1e30);
}

const std::vector<double>& StepBounds::steps(double error) {
  const auto [place, added] = steps_.try_emplace(error);
  std::vector<double>& steps = place->second;
  if (!added) return steps;
  std::vector<double> depths;
  double effect = 0, depth = 0;
  for (const Bound& bound : bounds_) {
    if (bound.effect != effect) {
      // missing a depth d loses the fraction 1 - e^{-d} of the light there and behind it
      effect = bound.effect;
      const double share = error / effect;
      depth = share < 1 ? -std::log1p(-share) : 1e30;
    }
    depths.push_back(depth);
  }
  // the second order takes a while to find, and does not matter where the first decides
  std::vector<bool> wanted;
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const Bound& bound = bounds_[i];
    const double by_first = bound.first > 0 ? depths[i] / bound.first : 1e30;
    wanted.push_back(!bound.complete && by_first < widest_step && by_first < bound.step(depths[i]));
  }
  if (std::find(wanted.begin(), wanted.end(), true) != wanted.end()) complete(wanted);
  for (std::size_t i = 0; i < bounds_.size(); ++i) steps.push_back(bounds_[i].step(depths[i]));
  return steps;
}

BrickSteps StepBounds::parts(double step, double error) {
  const std::vector<double>& allowed = steps(error);
  if (std::all_of(allowed.begin(), allowed.end(), [&](double most) { return most >= step; }))
    return {};
  auto parts = std::make_shared<std::vector<float>>(allowed.size());
  std::transform(allowed.begin(), allowed.end(), parts->begin(),
                 [&](double most) { return float(std::clamp(most / step, least_part, 1.0)); });
  return parts;
}

double StepBounds::widest(double error) const {
  double step = std::numeric_limits<double>::infinity();
  for (const Bound& bound : emission_)
    if (bound.first > 0)
      step = std::min(step, std::max(error / bound.first, std::sqrt(error / bound.second)));
  return step;
}

}  // namespace psivox
