#include "plan/trials.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "field/index_space.h"
#include "plan/brick_effects.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Smallest fraction of a step; below that, cells are cheaper.
constexpr double least_part = 1.0 / 4096;

/// Number of kinks that one ray may meet in a brick with errors of the same sign, divided by the 8
/// of h^2/8, which is what a trapezoid misses at one kink. From the pictures of
/// tools/bench/tolerance.py: the bound exceeds their largest errors.
constexpr double kinks_share = 4.0 / 8;

/// The same for emission, for which lattices use `midpoint`.
constexpr double emission_kinks_share = 4.0 / 8;

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

}  // namespace

StepBounds::StepBounds(const View& view, const MediumAtlas& atlas, double brightest,
                       std::span<const double> through)
    : density_(atlas.density),
      bounds_(atlas.density.bricks.size()),
      complete_(atlas.density.bricks.size()) {
  const Medium& medium = view.medium;
  const std::vector<BrickStats>& bricks = atlas.density.bricks;
  const double scale = medium.extinction * finest_voxel(*medium.density);
  kink_scale_ = scale * kinks_share;
  const double floor = std::max(1.0, brightest);
  std::optional<FunctionBends> bends;
  if (medium.transfer) bends.emplace(*medium.transfer);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double min = bricks[i].min, max = bricks[i].max, range = max - min;
    FunctionBend bend{1, 0, range};
    if (bends) bend = bends->between(min, max);
    // from a value to the vacuum of cells with absent corners, between two samples
    if (bricks[i].absent) bend.range = std::max(bend.range, bends ? bend.most : max);
    if (medium.gradient) {
      bend.range = medium.transfer->max_attenuation({min, max}, {0.0, 1e38});
      bend.turn = 1e38;
    }
    Bound& bound = bounds_[i];
    bound.effect = std::max(floor, through[i]);
    bound.first = scale * bend.range / 2;
    bound.slope = bend.slope;
    bound.turn = bend.turn;
    bound.second = kink_scale_ * bend.slope * double(bricks[i].second_difference);
  }
  for (std::size_t i = 0; i < medium.emission.size(); ++i)
    bound_emission(medium, i, atlas.emission[i]);
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
      steepest = std::min(steepest, greatest_slope(density_.texels.get() + i * brick_texels));
    bound.second = kink_scale_ * (bound.slope * double(kinks[i]) + bound.turn * steepest);
  });
  for (std::size_t i = 0; i < kinks.size(); ++i) complete_[i] = complete_[i] || wanted[i];
}

void StepBounds::bound_emission(const Medium& medium, std::size_t place,
                                const BrickAtlas& emission) {
  const std::vector<float> kinks = brick_kinks(emission);
  const double unit = finest_voxel(*medium.density);
  const double voxels =
      unit / finest_voxel(*medium.emission[place].field);  // of the emission in a step of 1
  // the errors of several grids add up
  const double scale = medium.emission[place].scale * unit * double(medium.emission.size());
  const std::size_t stride = std::size_t(emission.channels) * brick_texels;
  for (std::size_t i = 0; i < kinks.size(); ++i) {
    const float* values = emission.texels.get() + i * stride;
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
  steps.reserve(bounds_.size());
  // the second order takes a while to find, and does not matter where the first decides
  std::vector<bool> wanted;
  double effect = 0, depth = 0;
  for (const Bound& bound : bounds_) {
    if (bound.effect != effect) {
      // missing a depth d loses the fraction 1 - e^{-d} of the light there and behind it
      effect = bound.effect;
      const double share = error / effect;
      depth = share < 1 ? -std::log1p(-share) : 1e30;
    }
    const double by_first = bound.first > 0 ? depth / bound.first : 1e30;
    wanted.push_back(!complete_[steps.size()] && by_first < widest_step &&
                     by_first < bound.step(depth));
    steps.push_back(depth);
  }
  if (std::find(wanted.begin(), wanted.end(), true) != wanted.end()) complete(wanted);
  for (std::size_t i = 0; i < bounds_.size(); ++i) steps[i] = bounds_[i].step(steps[i]);
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
