#include "plan/step_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "field/index_space.h"
#include "plan/brick_effects.h"

namespace psivox {
namespace {

/// Smallest fraction of a step; below that, cells are cheaper.
constexpr double least_fraction = 1.0 / 4096;

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

/// The step at which the lesser of first * h and second * h^2 is `most`.
double step_at(double most, double first, double second) {
  return std::max(first > 0 ? most / first : 1e30, second > 0 ? std::sqrt(most / second) : 1e30);
}

/// What a step may miss of a brick's attenuation.
struct BrickBound {
  FunctionBend bend;
  double depth;  ///< [attenuation times voxels]

  double by_first() const { return step(HUGE_VAL); }
  /// With kinks of the attenuation of at most so much.
  double step(double kink) const { return step_at(depth, bend.range / 2, kinks_share * kink); }
};

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

std::vector<double> bounded_steps(const View& view, const MediumAtlas& atlas,
                                  std::span<const double> through, double brightest, double error) {
  const Medium& medium = view.medium;
  const BrickAtlas& density = atlas.density;
  const double scale = medium.extinction * finest_voxel(*medium.density);
  const FunctionBends bends(medium.transfer.get());
  std::vector<BrickBound> bounds;
  std::vector<double> steps;
  std::vector<bool> wanted;  // the second order takes a while, and matters where it may decide
  for (std::size_t i = 0; i < density.bricks.size(); ++i) {
    const BrickStats& brick = density.bricks[i];
    FunctionBend bend = bends.between(double(brick.min), double(brick.max));
    // from a value to the vacuum of cells with absent corners, between two samples
    if (brick.absent) bend.range = std::max(bend.range, bend.most);
    if (medium.gradient) {
      bend.range = medium.transfer->max_attenuation({brick.min, brick.max}, {0.0, 1e38});
      bend.turn = 1e38;
    }
    // missing a depth d loses the fraction 1 - e^{-d} of the light there and behind it
    const double light = std::max(through[i], brightest);
    bounds.push_back(
        {.bend = bend, .depth = (error < light ? -std::log1p(-error / light) : 1e30) / scale});
    const BrickBound& bound = bounds.back();
    const double inside = bend.slope * double(brick.second_difference);
    wanted.push_back(bound.by_first() < std::min(widest_step, bound.step(inside)));
    steps.push_back(bound.by_first());
  }
  if (std::ranges::count(wanted, true) == 0) return steps;
  const std::vector<float> kinks = brick_kinks(density, wanted);
  tbb::parallel_for(std::size_t{0}, kinks.size(), [&](std::size_t i) {
    if (!wanted[i]) return;
    const FunctionBend& bend = bounds[i].bend;
    // where the function bends, the attenuation's slope changes by the slope of the values times
    // the bend
    double steepest = double(density.bricks[i].max) - double(density.bricks[i].min);
    if (bend.turn > 0)
      steepest = std::min(steepest, greatest_slope(density.texels.get() + i * brick_texels));
    steps[i] = bounds[i].step(bend.slope * double(kinks[i]) + bend.turn * steepest);
  });
  return steps;
}

BrickSteps fractions_of(double step, std::span<const double> bounded) {
  if (std::ranges::all_of(bounded, [&](double most) { return most >= step; })) return {};
  auto fractions = std::make_shared<std::vector<float>>(bounded.size());
  std::ranges::transform(bounded, fractions->begin(), [&](double most) {
    return float(std::clamp(most / step, least_fraction, 1.0));
  });
  return fractions;
}

double widest_by_emission(const Medium& medium, const MediumAtlas& atlas, double error) {
  double widest = widest_step;
  for (std::size_t grid = 0; grid < medium.emission.size(); ++grid) {
    const BrickAtlas& emission = atlas.emission[grid];
    const std::vector<float> kinks = brick_kinks(emission);
    const double unit = finest_voxel(*medium.density);
    const double voxels =
        unit / finest_voxel(*medium.emission[grid].field);  // of the emission in a step of 1
    // the errors of several grids add up
    const double scale = medium.emission[grid].scale * unit * double(medium.emission.size());
    const std::size_t stride = std::size_t(emission.channels) * brick_texels;
    for (std::size_t i = 0; i < kinks.size(); ++i) {
      const float* values = emission.texels.get() + i * stride;
      const auto [least, most] = std::minmax_element(values, values + stride);
      const double first = scale * double(*most - *least);
      const double second = scale * voxels * kinks_share * double(kinks[i]);
      widest = std::min(widest, step_at(error, first, second));
    }
  }
  return widest;
}

}  // namespace psivox
