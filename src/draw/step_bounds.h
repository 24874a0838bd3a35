#pragma once

#include <vector>

#include "march/medium_atlas.h"

namespace psivox {

/// What a uniform step could at most miss in each brick, from what is stored in it: so that nothing
/// is lost that no sample touches. (docs/method.md, "Asked for an error")
class StepBounds {
 public:
  /// `brightest`: the greatest radiance that is seen behind a brick.
  StepBounds(const View& view, const MediumAtlas& atlas, double brightest);

  /// Of each brick the part of the step with which its bound is `error` [radiance, opacity], at
  /// most 1.
  std::vector<float> parts(double step, double error) const;

 private:
  /// The optical depth that a step h misses is at most the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
    double effect = 1;  ///< error of opacity or radiance where all is missed
  };
  std::vector<Bound> bounds_;
};

}  // namespace psivox
