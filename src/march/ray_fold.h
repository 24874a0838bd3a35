#pragma once

#include <glm/vec4.hpp>
#include <memory>

#include "psivox/medium.h"

namespace psivox {

/// Joins what a ray collects in the regions that it passes, front to back, and makes a picture of
/// it. What is collected has four numbers, which `collected` in shaders/modes.glsl defines for each
/// mode. Regions that follow each other may be joined first.
class RayFold {
 public:
  /// Of a view whose light is computed.
  explicit RayFold(const View& view);

  /// What a ray has collected before its first region.
  glm::dvec4 nothing() const;

  /// Adds what lies behind: radiance weighted with the transmittance so far, and the product of
  /// transmittances (Max 1995, eq. 8); optical depths add up; the greater of two maxima.
  void add_behind(glm::dvec4& ray, const glm::dvec4& behind) const;

  /// The depth that a ray has with what lies behind: the greater maximum's, else the first. +Inf:
  /// none. Given are those of both before they are joined. Of the transmittance's half the region
  /// must have been marched behind the others, see RenderOptions::passed.
  float depth(const glm::dvec4& ray, float own, const glm::dvec4& behind, float others) const;

  /// Whether nothing behind would change the picture of a ray by more than `least`, the
  /// transmittance below which rays end.
  bool ended(const glm::dvec4& ray, double least) const;

  /// R G B A of a ray that has passed all regions.
  glm::dvec4 picture(const glm::dvec4& ray) const;

  /// Its transmittance; 1 in modes without.
  double transmittance(const glm::dvec4& ray) const;

 private:
  struct Maxima;
  Shows shows_;
  std::shared_ptr<Maxima> maxima_;  ///< null if the mode shows no value
};

}  // namespace psivox
