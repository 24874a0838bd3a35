#include "draw/pick.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "march/march_double.h"

namespace psivox {
namespace {

/// The camera whose only pixel has this ray at its centre and the pixel width of `camera`.
Camera along(const WorldRay& ray, const Camera& camera, const glm::ivec2& resolution) {
  Camera narrow = camera;
  narrow.position = ray.origin;
  narrow.forward = ray.direction;
  narrow.target = ray.origin + ray.direction;
  narrow.right = glm::normalize(glm::cross(ray.direction, camera.up));
  narrow.up = glm::cross(narrow.right, ray.direction);
  narrow.half_width = camera.half_width / resolution.x;
  narrow.half_height = narrow.half_width;
  return narrow;
}

}  // namespace

std::optional<glm::dvec3> pick_point(const View& view, const MediumAtlas& atlas,
                                     const glm::dvec2& pixel) {
  const WorldRay ray = camera_ray(view.camera, view.scene.resolution, pixel.x, pixel.y);
  View one = view;
  one.camera = along(ray, view.camera, view.scene.resolution);
  one.scene.resolution = {1, 1};
  one.scene.pixel_samples = 1;
  one.scene.mode = from_front(one.scene.mode);
  const Image image = render_march_double(one, atlas, {.depth = true}).image;
  const double depth = image.layers.back().values.front();
  if (!std::isfinite(depth)) return {};
  return ray.origin + depth * ray.direction;
}

}  // namespace psivox
