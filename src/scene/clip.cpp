#include "scene/clip.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

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
  constexpr double infinity = std::numeric_limits<double>::infinity();
  glm::dvec2 part(0, infinity);
  for (const HalfSpace& half : clip) {
    const double distance = glm::dot(half.normal, ray.origin) - half.offset;
    const double speed = glm::dot(half.normal, ray.direction);
    if (speed > 0)
      part.x = std::max(part.x, -distance / speed);
    else if (speed < 0)
      part.y = std::min(part.y, -distance / speed);
    else if (distance < 0)
      part.y = -infinity;
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
    const glm::dmat3 index_from_world = glm::transpose(glm::dmat3(grid.world_from_index));
    std::erase_if(grid.blocks, [&](const VisibleBlock& block) {
      return std::ranges::any_of(clip, [&](const HalfSpace& half) {
        const glm::dvec3 per_voxel = index_from_world * half.normal;
        const double farthest = glm::dot(half.normal, glm::dvec3(grid.world_from_index[3])) +
                                glm::dot(per_voxel, 0.5 * (block.min + block.max)) +
                                glm::dot(glm::abs(per_voxel), 0.5 * (block.max - block.min));
        return farthest <= half.offset;
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
