#include "scene/cuts.h"

#include <algorithm>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/text.h"

namespace psivox {

static HalfSpace bounded_by(const Plane& plane) {
  const glm::dvec3 normal = glm::normalize(plane.normal);
  return {normal, glm::dot(normal, plane.point.value_or(glm::dvec3(0)))};
}

std::vector<HalfSpace> clip_of(const Scene& scene) {
  std::vector<HalfSpace> clip;
  if (scene.clip) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 normal(0);
      normal[axis] = 1;
      clip.push_back({normal, scene.clip->min[axis]});
      clip.push_back({-normal, -scene.clip->max[axis]});
    }
  }
  if (scene.clip_plane) clip.push_back(bounded_by(*scene.clip_plane));
  return clip;
}

std::vector<HalfSpace> cuts_of(const Scene& scene) {
  std::vector<HalfSpace> cuts = clip_of(scene);
  if (scene.shows(Shows::plane) && scene.slice) cuts.push_back(bounded_by(*scene.slice));
  return cuts;
}

glm::dvec2 clip_interval(const std::vector<HalfSpace>& clip, const WorldRay& ray) {
  glm::dvec2 part(0, HUGE_VAL);
  for (const HalfSpace& half : clip) {
    const double distance = glm::dot(half.normal, ray.origin) - half.offset;
    const double speed = glm::dot(half.normal, ray.direction);
    if (speed > 0)
      part.x = std::max(part.x, -distance / speed);
    else if (speed < 0)
      part.y = std::min(part.y, -distance / speed);
    else if (distance < 0)
      part.y = -HUGE_VAL;
  }
  return part;
}

Scene with_planes(Scene scene, const Subject& subject) {
  if (scene.shows(Shows::plane) && !scene.slice)
    scene.slice = Plane{z_is_up(scene, subject) ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1)};
  for (std::optional<Plane> Scene::*plane : {&Scene::clip_plane, &Scene::slice})
    if (scene.*plane && !(scene.*plane)->point) (scene.*plane)->point = middle_of(subject);
  return scene;
}

static void cut(Subject& subject, const std::vector<HalfSpace>& clip) {
  for (VisibleGrid& grid : subject.grids) {
    std::erase_if(grid.blocks, [&](const VisibleBlock& block) {
      return std::ranges::any_of(clip, [&](const HalfSpace& half) {
        return grid.reach(block, half.normal) <= half.offset;
      });
    });
  }
  std::erase_if(subject.grids, [](const VisibleGrid& grid) { return grid.blocks.empty(); });
}

bool cuts_all(Subject subject, const std::vector<HalfSpace>& clip) {
  if (!subject.grids.empty()) cut(subject, clip);
  return !clip.empty() && subject.grids.empty();
}

Subject clipped(const Subject& subject, const std::vector<HalfSpace>& clip) {
  Subject seen = subject;
  cut(seen, clip);
  return seen.grids.empty() ? subject : seen;
}

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
