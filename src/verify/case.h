#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "psivox/draw.h"
#include "psivox/verify.h"
#include "verify/closed_forms.h"

namespace psivox {

/// Draws views with the filter under test; computes a view's light if it has one.
class Painter {
 public:
  Painter(Marcher& gpu, Filter filter) : gpu_(gpu), filter_(filter) {}
  Filter filter() const { return filter_; }
  Image picture(View view) const;
  /// Rays that stood still before their end, of the pictures since the last call.
  std::uint64_t take_stuck() const { return std::exchange(stuck_, 0); }

 private:
  Marcher& gpu_;
  Filter filter_;
  mutable std::uint64_t stuck_ = 0;
};

/// Errors of a case's pictures.
struct Measured {
  double error = 0;
  /// Largest change of the picture per error of 1 in every interpolation weight. Times 2^-8 it
  /// bounds what the hardware filter may add.
  double sensitivity = 0;

  void add(const Measured& other);  ///< the larger of each
};

/// A case of verify: pictures, and what they must show.
struct Case {
  std::string name;
  std::string reason;
  double bound;  ///< with the exact filter
  std::function<Measured(const Painter&)> measure;
  bool hardware = true;  ///< false: the hardware filter's bound is too wide to tell anything
};

/// The larger of two; NaN if either is NaN.
double larger(double a, double b);

/// The error that a case found, with the bound for its filter.
VerifyCase run_case(const Case& c, const Painter& painter);

/// Largest |A - (1 - e^{-depth})| over the pixels, or |RGB - color A|, relative to the largest
/// color if that is above 1. `depth` gives the optical depth of a ray.
double opacity_error(const View& view, const Image& image,
                     const std::function<double(const WorldRay&)>& depth);

/// Largest |R - radiance| over the pixels of a picture whose radiance is the same everywhere.
double radiance_error(const Image& image, double radiance);

/// Largest |a - b| over R G B A, relative to the largest number in `a` if that is above 1. +Inf if
/// `a` is empty or shows a single opaque plane.
double picture_difference(const Image& a, const Image& b);

/// The cases, in the order in which they run.
std::vector<Case> opacity_cases();   ///< test the optical depth alone
std::vector<Case> radiance_cases();  ///< test the weights
std::vector<Case> source_cases();  ///< test transfer functions, emission, light and a ray template
std::vector<Case> invariance_cases();  ///< draw the same medium, given in several ways

}  // namespace psivox
