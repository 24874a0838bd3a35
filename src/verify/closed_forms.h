#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/camera.h"
#include "psivox/field.h"

// Rays with known integrals, in double. No code is shared with the march or the reference.

namespace psivox {

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

/// Integral along the ray, from its origin, of the tent of one voxel with value 1. Between faces of
/// cells the tent is a cubic, which Simpson's rule integrates exactly.
double tent_along(const WorldRay& ray, const glm::ivec3& voxel,
                  const glm::dmat4& index_from_world = glm::dmat4(1.0));

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

}  // namespace psivox
