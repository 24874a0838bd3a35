#pragma once

#include <map>
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

/// Bounds, from the values stored in each brick, how much a uniform step can miss there, so that no
/// feature between samples is lost. (docs/method.md, "Asked for an error")
class StepBounds {
 public:
  /// `through`: see light_through; `brightest`: the least of it. The atlas must outlive it.
  StepBounds(const View& view, const MediumAtlas& atlas, std::span<const double> through,
             double brightest);

  /// For each brick, the fraction of the step at which its bound is `error` [radiance, opacity], at
  /// most 1. Null where all are 1.
  BrickSteps parts(double step, double error);

  /// The widest step at which the bound of the emission is `error` [radiance]; infinite without
  /// emission. It holds everywhere, since a flame goes beyond the density's bricks.
  double widest(double error) const;

 private:
  /// A step h misses an optical depth of at most the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
    double light = 1;  ///< through it
    double slope = 1;  ///< greatest of the attenuation by the values
    double turn = 0;   ///< sum of its changes
    /// Whether `second` counts all kinks, and not only those inside the brick.
    bool complete = false;

    /// The step at which it is `depth` [optical depth].
    double step(double depth) const;
    /// The optical depth at which the error is `error` [radiance, opacity].
    double depth(double error) const;
  };
  /// Adds to the wanted bounds the kinks on faces and where a function bends.
  void complete(const std::vector<bool>& wanted);
  /// `place`: in the medium's emission.
  void bound_emission(const Medium& medium, std::size_t place, const BrickAtlas& emission);
  /// For each brick, the step at which its bound is `error`.
  const std::vector<double>& steps(double error);

  const BrickAtlas& density_;
  double kink_scale_;  ///< optical depth that a step of 1 may miss at a kink of 1
  std::vector<Bound> bounds_;
  std::map<double, std::vector<double>> steps_;  ///< by error
  std::vector<Bound> emission_;                  ///< of the emission's bricks [radiance]
};

}  // namespace psivox
