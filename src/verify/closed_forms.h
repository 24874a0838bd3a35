#pragma once

#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/camera.h"
#include "psivox/field.h"

// Rays whose integrals are known, in double and without a line of the march's or the reference's.

namespace psivox {

/// A field that varies along x of its index space only: values at x = 0, 1, ..., linear in between
/// and to the 0 at -1 and behind the last. In y and z it ends, so rays have to pass it by its two
/// faces across x; what is said of another ray is NaN.
struct Plate {
  std::vector<double> values;  ///< that a float holds
  glm::ivec3 at{0};            ///< voxel of the first value, in the middle of y and z
  glm::dmat4 world_from_index{1.0};
  int half_width = 30;  ///< [voxels]

  Field field() const;
  double value(int x) const;
  /// Integral of the value over x.
  double across(double from, double to) const;
  /// Sum of |differences| of neighbours.
  double variation() const;
  /// The ray's direction across x [voxels/world unit].
  double slope(const WorldRay& ray) const;
  /// Integral of the value along the ray, from its origin on [world units].
  double along(const WorldRay& ray) const;
};

/// Values f(0), f(1), ..., as floats hold them.
template <typename Value>
std::vector<double> profile(int count, Value value) {
  std::vector<double> values;
  for (int x = 0; x < count; ++x) values.push_back(double(float(value(x))));
  return values;
}

/// Integral along the ray, from its origin on, of the tent of one voxel of value 1: between the
/// faces of cells it is a cubic, for which Simpson's rule is exact.
double tent_along(const WorldRay& ray, const glm::ivec3& voxel,
                  const glm::dmat4& index_from_world = glm::dmat4(1.0));

/// Radiance of a medium whose value rises from 0 by m a world unit, tau = K value, L = value, as
/// seen against the rise and with nothing seen of its end: the integral of K v^2 e^{-K v^2/(2m)}
/// dv/m.
double rising_glow(double K, double m);

/// A rule's segment: weights of the luminance at its ends, and its transparency.
struct SegmentSum {
  double front, back, transparency;
};

/// Moreland 2004, eq. 53 to 56 with eq. 65, as printed: optical lengths of the ends.
SegmentSum weighted_opacity(double front, double back);

/// The balanced weights of docs/method.md, as printed.
SegmentSum balanced(double front, double back);

/// Radiance of the plate of tau = K value by a rule, seen along x, by segments of 1/parts of a
/// voxel from -1 on. L: of voxels, linear in between; the value itself if not given.
double rule_across(const Plate& plate, double K, int parts, SegmentSum (*rule)(double, double),
                   const std::function<double(int x)>& L = {});

}  // namespace psivox
