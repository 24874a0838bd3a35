#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <vector>

#include "psivox/camera.h"
#include "verify/made.h"

// Rays with known integrals, in double. They share no code with the march or the reference.

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

/// Integral along the ray, from its origin, of the tent of one voxel with value 1, in index space.
/// Between faces of cells the tent is a cubic, which Simpson's rule integrates exactly.
double tent_along(const WorldRay& ray, const glm::ivec3& voxel);

/// Radiance of a medium whose value rises from 0 by m per world unit, with tau = K value and L =
/// value. The camera looks against the rise, and the medium is opaque before its end. It is the
/// integral of K v^2 e^{-K v^2/(2m)} dv/m.
double rising_glow(double K, double m);

inline Field Plate::field() const {
  const int last = int(values.size()) - 1;
  const glm::ivec3 side(0, half_width, half_width);
  return make_field(
      {at - side, at + side + glm::ivec3(last, 0, 0)},
      [this](glm::ivec3 v) { return float(value(v.x - at.x)); }, world_from_index);
}

inline double Plate::value(int x) const {
  return x < 0 || x >= int(values.size()) ? 0 : values[std::size_t(x)];
}

inline double Plate::across(double from, double to) const {
  double sum = 0;
  for (int x = -1; x < int(values.size()); ++x) {
    const double a = std::clamp(from - x, 0.0, 1.0), b = std::clamp(to - x, 0.0, 1.0);
    sum += (b - a) * std::lerp(value(x), value(x + 1), 0.5 * (a + b));
  }
  return sum;
}

inline double Plate::variation() const {
  double sum = 0;
  for (int x = -1; x < int(values.size()); ++x) sum += std::abs(value(x + 1) - value(x));
  return sum;
}

inline double Plate::slope(const WorldRay& ray) const {
  return (glm::inverse(glm::dmat3(world_from_index)) * ray.direction).x;
}

inline double Plate::along(const WorldRay& ray) const {
  const glm::dvec3 d = glm::inverse(glm::dmat3(world_from_index)) * ray.direction;
  const glm::dvec3 p =
      glm::dvec3(glm::inverse(world_from_index) * glm::dvec4(ray.origin, 1)) - glm::dvec3(at);
  const double low = -1, high = double(values.size());
  const double first = std::clamp(p.x, low, high), last = d.x > 0 ? high : low;
  for (const double x : {first, last}) {
    const glm::dvec3 q = glm::abs(p + d * ((x - p.x) / d.x));
    if (!(std::max(q.y, q.z) <= half_width)) return std::numeric_limits<double>::quiet_NaN();
  }
  return across(std::min(first, last), std::max(first, last)) / std::abs(d.x);
}

inline double tent_along(const WorldRay& ray, const glm::ivec3& voxel) {
  const glm::dvec3 d = ray.direction, p = ray.origin - glm::dvec3(voxel);
  std::vector<double> faces = {0};
  for (int axis = 0; axis < 3; ++axis)
    for (const double face : {-1.0, 0.0, 1.0})
      if (d[axis] != 0) faces.push_back(std::max(0.0, (face - p[axis]) / d[axis]));
  std::sort(faces.begin(), faces.end());
  const auto value = [&](double t) {
    const glm::dvec3 w = glm::max(1.0 - glm::abs(p + t * d), 0.0);
    return w.x * w.y * w.z;
  };
  double sum = 0;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    const double a = faces[i - 1], b = faces[i];
    sum += (b - a) / 6 * (value(a) + 4 * value(0.5 * (a + b)) + value(b));
  }
  return sum;
}

inline double rising_glow(double K, double m) { return std::sqrt(std::numbers::pi * m / (2 * K)); }

}  // namespace psivox
