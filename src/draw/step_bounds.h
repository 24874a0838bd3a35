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

 private:
  /// A step h misses an optical depth of at most the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
    double effect = 1;  ///< error of opacity or radiance if everything is missed
  };
  std::vector<Bound> bounds_;
};

}  // namespace psivox
