#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "psivox/medium.h"
#include "ray_radiance.h"
#include "scene/cuts.h"

namespace psivox {

/// The contribution of one ray to a pixel.
struct RayPicture {
  glm::dvec3 radiance{0};  ///< premultiplied
  double opacity = 0;
  double error = 0;  ///< bound on the error of the worst channel of radiance and opacity
  double depth =
      std::numeric_limits<double>::infinity();  ///< of the maximum or the surface [world]
  std::uint64_t cells = 0;                      ///< crossed, with a corner that is not 0
};

/// Draws rays by the mode of a scene; one for each thread.
class RayModes {
 public:
  /// `view` and its `medium` must outlive it.
  RayModes(const View& view, const RayMedium& medium, double tolerance);

  /// The ray up to the distance `end` [world units].
  RayPicture picture(const WorldRay& ray, double end);

 private:
  RayPicture radiance(const WorldRay& ray);
  RayPicture depth(const WorldRay& ray);
  RayPicture maximum(const WorldRay& ray);
  RayPicture surface(const WorldRay& ray);

  const View* view_;
  const RayMedium* medium_;
  RayIntegrator integrator_;
  std::vector<HalfSpace> clip_;
  glm::dvec2 part_{0};               ///< of the ray that is drawn: before its end, in the clip
  std::optional<BlockCache> cache_;  ///< of the density grid, for maxima and surfaces
};

}  // namespace psivox
