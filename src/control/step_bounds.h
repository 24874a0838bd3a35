#pragma once

#include <vector>

#include "psivox/medium_atlas.h"

namespace psivox {

/// What a uniform step could at most miss in each brick, from what is stored in it: so that nothing
/// is lost that no sample touches. (docs/method.md, "Asked for an error")
class StepBounds {
 public:
  StepBounds(const View& view, const MediumAtlas& atlas);

  /// Of each brick the part of the step with which its bound is `error` [radiance, opacity], at
  /// most 1.
  std::vector<float> parts(double step, double error) const;

 private:
  /// The error of a step h is the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
  };
  std::vector<Bound> bounds_;
};

}  // namespace psivox
