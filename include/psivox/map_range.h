#pragma once

#include <glm/vec2.hpp>
#include <vector>

namespace psivox {

/// The values at the ends of a map. Each is a number, or a percentile of the active values [%].
struct MapRange {
  MapRange(const glm::dvec2& ends_ = {0, 1}, const glm::bvec2& percent_ = {false, false})
      : ends(ends_), percent(percent_) {}

  glm::dvec2 ends;
  glm::bvec2 percent;  ///< whether an end is a percentile
  bool operator==(const MapRange&) const = default;
};

/// The factor of the attenuation over a MapRange: linear between points and constant outside.
struct OpacityCurve {
  std::vector<glm::dvec2> points{};  ///< place, 0 to 1, strictly ascending; and factor, at least 0
  bool operator==(const OpacityCurve&) const = default;

  double at(double place) const;
};

}  // namespace psivox
