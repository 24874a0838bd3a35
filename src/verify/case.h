#pragma once

#include <functional>
#include <string>
#include <vector>

#include "psivox/draw.h"
#include "psivox/verify.h"
#include "verify/closed_forms.h"

namespace psivox {

/// Draws views, lit where they have a light, with the filter that is verified.
class Painter {
 public:
  Painter(Marcher& gpu, Filter filter) : gpu_(gpu), filter_(filter) {}
  Filter filter() const { return filter_; }
  Image picture(View view) const;

 private:
  Marcher& gpu_;
  Filter filter_;
};

/// What a case's pictures are off by.
struct Measured {
  double error = 0;
  /// By how much they may change where every weight of an interpolation is off by 1; times 2^-8 it
  /// is what the hardware filter may add.
  double sensitivity = 0;

  void add(const Measured& other);  ///< the larger of each
};

/// A case of verify: pictures and what they must be.
struct Case {
  std::string name;
  std::string reason;
  double bound;  ///< with the exact filter
  std::function<Measured(const Painter&)> measure;
  bool hardware = true;  ///< the hardware filter's bound says something
};

/// The larger of two; NaN if one is.
double larger(double a, double b);

/// What a case found, with the bound of its filter.
VerifyCase run_case(const Case& c, const Painter& painter);

/// Largest |A - (1 - e^{-depth})| over the pixels, and |RGB - color A| over the largest color where
/// that is above 1. `depth`: of a ray.
double opacity_error(const View& view, const Image& image,
                     const std::function<double(const WorldRay&)>& depth);

/// Largest |R - radiance| over the pixels, for pictures of one radiance.
double radiance_error(const Image& image, double radiance);

/// Largest |a - b| of R G B A, over the largest number in `a` where that is above 1; +Inf where `a`
/// shows nothing, or nothing but one opaque plane.
double picture_difference(const Image& a, const Image& b);

/// The cases, in the order in which they are run.
std::vector<Case> opacity_cases();     ///< of the optical depth alone
std::vector<Case> radiance_cases();    ///< of weights
std::vector<Case> source_cases();      ///< of a transfer function, emission, light; a template
std::vector<Case> invariance_cases();  ///< one picture of one medium given in several ways

}  // namespace psivox
