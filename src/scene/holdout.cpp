#include "scene/holdout.h"

#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/text.h"

namespace psivox {

double Holdout::z(const Camera& camera, const glm::ivec2& resolution,
                  const glm::ivec2& pixel) const {
  // the same pixel, unless the picture is a smaller one of the same frame
  const glm::dvec2 place = (glm::dvec2(pixel) + 0.5) * glm::dvec2(size) / glm::dvec2(resolution);
  const glm::ivec2 at = glm::clamp(glm::ivec2(place), glm::ivec2(0), size - 1);
  const double depth = double(depths[std::size_t(at.y) * std::size_t(size.x) + std::size_t(at.x)]);
  if (!(depth > 0) || !std::isfinite(depth)) return HUGE_VAL;
  if (kind == DepthKind::z) return depth;
  const WorldRay centre = camera_ray(camera, size, at.x + 0.5, at.y + 0.5);
  return depth * glm::dot(centre.direction, camera.forward);
}

double held_at(const Holdout* holdout, const Camera& camera, const glm::ivec2& resolution,
               const glm::ivec2& pixel, const WorldRay& ray) {
  if (!holdout) return HUGE_VAL;
  return holdout->z(camera, resolution, pixel) / glm::dot(ray.direction, camera.forward);
}

LayerOfFile::LayerOfFile(const std::string& text) : file(text) {
  const std::size_t colon = text.rfind(':');
  if (colon == text.npos || !lower_case(text.substr(0, colon)).ends_with(".exr")) return;
  file = text.substr(0, colon);
  layer = text.substr(colon + 1);
}

}  // namespace psivox
