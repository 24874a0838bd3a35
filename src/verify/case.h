#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <vector>

#include "psivox/camera.h"
#include "psivox/draw.h"
#include "psivox/field.h"
#include "psivox/verify.h"

namespace psivox {

// Rays with known integrals, in double, share no code with the march or the reference.

/// A field that varies only along x of its index space. Values are given at x = 0, 1, ... and are
/// linear in between, falling to 0 at -1 and one voxel after the last. The field ends in y and z,
/// so a ray must cross both faces across x; for any other ray the results are NaN.
struct Plate {
  std::vector<double> values;  ///< exactly representable as float
  glm::ivec3 at{0};            ///< voxel of the first value, in the middle of y and z
  glm::dmat4 world_from_index{1.0};
  int half_width = 30;  ///< [voxels]

  Field field() const;
  double value(int x) const;
  /// Integral of the value over x.
  double across(double from, double to) const;
  /// Sum of |differences| of neighbouring values.
  double variation() const;
  /// The ray's direction across x [voxels/world unit].
  double slope(const WorldRay& ray) const;
  /// Integral of the value along the ray from its origin [world units].
  double along(const WorldRay& ray) const;
};

/// Values f(0), f(1), ..., rounded to float.
template <typename Value>
std::vector<double> profile(int count, Value value) {
  std::vector<double> values;
  for (int x = 0; x < count; ++x) values.push_back(double(float(value(x))));
  return values;
}

/// Integral along the ray, from its origin, of the tent of one voxel with value 1, in index space.
/// Between faces of cells the tent is a cubic, which Simpson's rule integrates exactly.
double tent_along(const WorldRay& ray, const glm::ivec3& voxel);

/// Radiance of a medium whose value rises from 0 by m per world unit, with tau = K value and L =
/// value. The camera looks against the rise, and the medium is opaque before its end. It is the
/// integral of K v^2 e^{-K v^2/(2m)} dv/m.
double rising_glow(double K, double m);

/// One segment of a rule: the luminance weights of its ends, and its transparency.
struct SegmentSum {
  double front, back, transparency;
};

/// Moreland 2004, eq. 53 to 56 with eq. 65, as printed. The arguments are the optical lengths of
/// the ends.
SegmentSum weighted_opacity(double front, double back);

/// The balanced weights of docs/method.md, as printed.
SegmentSum balanced(double front, double back);

/// Radiance of the plate with tau = K value, by a rule, seen along x, in segments of 1/parts of a
/// voxel from -1. `L` gives the luminance at voxels, linear in between; without it L is the value.
double rule_across(const Plate& plate, double K, int parts, SegmentSum (*rule)(double, double),
                   const std::function<double(int x)>& L = {});

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
