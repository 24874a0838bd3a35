#include "plan/step_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "field/index_space.h"
#include "plan/brick_effects.h"

namespace psivox {
namespace {

/// Smallest fraction of a step; below that, cells are cheaper.
constexpr double least_part = 1.0 / 4096;

/// Number of kinks that one ray may meet in a brick with errors of the same sign, divided by the 8
/// of h^2/8, which is what a step misses at one kink. From the pictures of
/// tools/bench/tolerance.py: the bound exceeds their largest errors.
constexpr double kinks_share = 4.0 / 8;

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

std::vector<double> light_through(const View& view, const MediumAtlas& atlas,
                                  const Backdrop& behind, std::span<const SeenPixel> seen) {
  const Medium& medium = view.medium;
  double common = std::max({1.0, behind.greatest()});
  for (const SeenPixel& pixel : seen)
    common = std::max(common, greatest_of(glm::dvec3(pixel.picture)));
  for (const Medium& other : medium.others) common = std::max(common, brightest_ray(other));
  const double scale =
      greatest_of(medium.color) * (atlas.luminance ? greatest_of(*atlas.luminance) : 1);
  const bool colored = medium.source == LuminanceSource::transfer || medium.lit_colors;
  std::vector<double> through;
  for (const BrickStats& brick : atlas.density.bricks) {
    double own = scale;
    if (medium.source == LuminanceSource::density) own *= double(brick.max);
    if (colored) own *= greatest_of(medium.transfer->max_color(brick.min, brick.max));
    through.push_back(std::max(common, own + greatest_of(medium.ambient)));
  }
  return through;
}

StepBounds::StepBounds(const View& view, const MediumAtlas& atlas, std::span<const double> through,
                       double brightest)
    : density_(atlas.density) {
  const Medium& medium = view.medium;
  const double scale = medium.extinction * finest_voxel(*medium.density);
  kink_scale_ = scale * kinks_share;
  const FunctionBends bends(medium.transfer.get());
  for (const BrickStats& brick : atlas.density.bricks) {
    FunctionBend bend = bends.between(double(brick.min), double(brick.max));
    // from a value to the vacuum of cells with absent corners, between two samples
    if (brick.absent) bend.range = std::max(bend.range, bend.most);
    if (medium.gradient) {
      bend.range = medium.transfer->max_attenuation({brick.min, brick.max}, {0.0, 1e38});
      bend.turn = 1e38;
    }
    bounds_.push_back({.first = scale * bend.range / 2,
                       .second = kink_scale_ * bend.slope * double(brick.second_difference),
                       .light = std::max(through[bounds_.size()], brightest),
                       .slope = bend.slope,
                       .turn = bend.turn});
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
    bound.complete = true;
  });
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
        {scale * double(*most - *least), scale * voxels * kinks_share * double(kinks[i])});
  }
}

double StepBounds::Bound::step(double depth) const {
  return std::max(first > 0 ? depth / first : 1e30, second > 0 ? std::sqrt(depth / second) : 1e30);
}

double StepBounds::Bound::depth(double error) const {
  // missing a depth d loses the fraction 1 - e^{-d} of the light there and behind it
  return error < light ? -std::log1p(-error / light) : 1e30;
}

const std::vector<double>& StepBounds::steps(double error) {
  const auto [place, added] = steps_.try_emplace(error);
  std::vector<double>& steps = place->second;
  if (!added) return steps;
  // the second order takes a while to find, and does not matter where the first decides
  std::vector<bool> wanted;
  for (const Bound& bound : bounds_) {
    steps.push_back(bound.depth(error));
    const double by_first = bound.first > 0 ? steps.back() / bound.first : 1e30;
    wanted.push_back(!bound.complete && by_first < widest_step &&
                     by_first < bound.step(steps.back()));
  }
  if (std::ranges::count(wanted, true) > 0) complete(wanted);
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
