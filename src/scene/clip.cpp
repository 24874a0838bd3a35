#include "scene/clip.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace psivox {

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
  if (scene.clip_plane) {
    const glm::dvec3 normal = glm::normalize(scene.clip_plane->normal);
    clip.push_back({normal, glm::dot(normal, scene.clip_plane->point.value_or(glm::dvec3(0)))});
  }
  return clip;
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

}  // namespace psivox
