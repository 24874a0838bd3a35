#pragma once

#include <cmath>
#include <glm/vec3.hpp>

namespace psivox::view {

/// Rounds to a multiple of the largest power of ten that is at most `unit`, which keeps command
/// lines short.
inline double rounded_to(double value, double unit) {
  const double digits = std::pow(10.0, std::ceil(-std::log10(unit)));
  // + 0: -0 is 0
  return std::isfinite(digits) && digits > 0 ? std::round(value * digits) / digits + 0.0 : value;
}

inline glm::dvec3 rounded_to(const glm::dvec3& value, double unit) {
  return {rounded_to(value.x, unit), rounded_to(value.y, unit), rounded_to(value.z, unit)};
}

}  // namespace psivox::view
