#pragma once

#include <span>
#include <vector>

#include "plan/pilot.h"

namespace psivox {

/// Widest and narrowest step tried [voxels].
inline constexpr double widest_step = 16, narrowest_step = 1.0 / 64;

/// By slot of the density's bricks: the greatest radiance that is to be expected through each, at
/// least 1. A brick that misses an optical depth d is off by at most d times that. It counts the
/// brick's own luminance, what is behind the medium, further volumes, and the pixels that were
/// `seen` to be bright: a bound of emission without what attenuates it is 25 times what a flame
/// shows.
std::vector<double> light_through(const View& view, const MediumAtlas& atlas,
                                  const Backdrop& behind, std::span<const SeenPixel> seen = {});

/// By slot of the density's bricks: the step at which a bound of what a uniform step can miss
/// there, from the values stored in the brick, is `error` [radiance, opacity], so that no feature
/// between samples is lost. (docs/method.md, "Asked for an error") `through`: see light_through;
/// `brightest`: the least of it.
std::vector<double> bounded_steps(const View& view, const MediumAtlas& atlas,
                                  std::span<const double> through, double brightest, double error);

/// The fractions of a step that bricks take whose own steps are at most `bounded`. Null where all
/// are 1.
BrickSteps fractions_of(double step, std::span<const double> bounded);

/// The widest step to try, at which the bound of the emission is `error` [radiance] at most. It
/// holds everywhere, since a flame goes beyond the density's bricks.
double widest_by_emission(const Medium& medium, const MediumAtlas& atlas, double error);

}  // namespace psivox
