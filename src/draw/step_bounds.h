#pragma once

#include <vector>

#include "march/medium_atlas.h"

namespace psivox {

/// Bounds, from the values stored in each brick, how much a uniform step can miss there, so that no
/// feature between samples is lost. (docs/method.md, "Asked for an error")
class StepBounds {
 public:
  /// `brightest`: the largest radiance behind any brick.
  StepBounds(const View& view, const MediumAtlas& atlas, double brightest);

  /// For each brick, the fraction of the step at which its bound is `error` [radiance, opacity], at
  /// most 1.
  std::vector<float> parts(double step, double error) const;

  /// The widest step at which the bound of the emission is `error` [radiance]; infinite without
  /// emission. It holds everywhere, since a flame goes beyond the density's bricks.
  double widest(double error) const;

 private:
  /// A step h misses an optical depth of at most the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
    double effect = 1;  ///< error of opacity or radiance if everything is missed
  };
  void bound_emission(const View& view, const BrickAtlas& emission);

  std::vector<Bound> bounds_;
  std::vector<Bound> emission_;  ///< of the emission's bricks [radiance]
};

}  // namespace psivox
