#include "march/pixel_box.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "field/index_space.h"

namespace psivox {

PixelBox common(const PixelBox& a, const PixelBox& b) {
  const glm::ivec2 from = glm::max(a.origin, b.origin);
  const glm::ivec2 to = glm::min(a.origin + a.size, b.origin + b.size);
  const PixelBox box{from, to - from};
  return box.empty() ? PixelBox{} : box;
}

std::vector<PixelBox> around(const PixelBox& inner, const PixelBox& all) {
  if (inner.empty()) return {all};
  const glm::ivec2 end = all.origin + all.size, inner_end = inner.origin + inner.size;
  std::vector<PixelBox> parts{
      {all.origin, {all.size.x, inner.origin.y - all.origin.y}},
      {{all.origin.x, inner_end.y}, {all.size.x, end.y - inner_end.y}},
      {{all.origin.x, inner.origin.y}, {inner.origin.x - all.origin.x, inner.size.y}},
      {{inner_end.x, inner.origin.y}, {end.x - inner_end.x, inner.size.y}}};
  std::erase_if(parts, [](const PixelBox& part) { return part.empty(); });
  return parts;
}

PixelBox pixels_of(const View& view, const glm::dvec3& low, const glm::dvec3& high) {
  const PixelBox all{{}, view.scene.resolution};
  const Camera& camera = view.camera;
  if (low.x >= high.x || low.y >= high.y || low.z >= high.z) return {};
  // where voxels are cells, each lies around its first corner
  const glm::dvec3 begin = low - (view.medium.nearest ? 0.5 : 0.0);
  const glm::dvec2 size(all.size);
  glm::dvec2 first(HUGE_VAL), last(-HUGE_VAL);
  int behind = 0, beside = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner = glm::mix(begin, high, glm::dvec3(cube_corner(i)));
    const glm::dvec3 to =
        glm::dvec3(view.medium.density->world_from_index * glm::dvec4(corner, 1)) - camera.position;
    const double along = camera.orthographic ? 1 : glm::dot(to, camera.forward);
    behind += along <= 0;
    beside += along <= 1e-3 * glm::length(to) && !camera.orthographic;
    const glm::dvec2 on(glm::dot(to, camera.right) / (along * camera.half_width),
                        glm::dot(to, camera.up) / (along * camera.half_height));
    const glm::dvec2 pixel(0.5 * (1 + on.x) * size.x, 0.5 * (1 - on.y) * size.y);
    first = glm::min(first, pixel);
    last = glm::max(last, pixel);
  }
  if (behind == 8) return {};
  if (beside > 0) return all;
  const glm::ivec2 from(glm::clamp(glm::floor(first) - 1.0, glm::dvec2(0), size));
  const glm::ivec2 to(glm::clamp(glm::floor(last) + 2.0, glm::dvec2(0), size));
  return {from, to - from};
}

PixelBox pixels_of(const View& view, const Box& bricks) {
  if (!view.medium.emission.empty() || !view.medium.others.empty())
    return {{}, view.scene.resolution};
  const Box domain = view.medium.density->domain();
  return pixels_of(view, glm::max(8.0 * glm::dvec3(bricks.min), glm::dvec3(domain.min)),
                   glm::min(8.0 * glm::dvec3(bricks.max) + 8.0, glm::dvec3(domain.max)));
}

}  // namespace psivox
