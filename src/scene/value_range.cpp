#include "scene/value_range.h"

#include <algorithm>
#include <limits>

#include "psivox/leaf_values.h"
#include "psivox/value_percentile.h"

namespace psivox {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void include(glm::dvec2& range, float value) {
  range.x = std::min(range.x, static_cast<double>(value));
  range.y = std::max(range.y, static_cast<double>(value));
}

bool inside(const Box& box, const glm::ivec3& voxel) {
  return voxel.x >= box.min.x && voxel.y >= box.min.y && voxel.z >= box.min.z &&
         voxel.x <= box.max.x && voxel.y <= box.max.y && voxel.z <= box.max.z;
}

}  // namespace

glm::dvec2 stored_range(const Field& field) {
  if (field.stored_range) return glm::dvec2(*field.stored_range);
  glm::dvec2 range(0);
  for (const Leaf& leaf : field.leaves) {
    const auto [low, high] = std::minmax_element(leaf.values, leaf.values + 512);
    include(range, *low);
    include(range, *high);
  }
  for (const Tile& tile : field.tiles) include(range, tile.value.x);
  return range;
}

glm::dvec2 active_range(const Field& field) {
  if (field.active_range) return glm::dvec2(*field.active_range);
  glm::dvec2 range(infinity, -infinity);
  for (const Leaf& leaf : field.leaves) {
    for (int i = 0; i < 512; ++i) {
      const glm::ivec3 voxel = leaf.origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
      if (inside(field.active_box, voxel)) include(range, leaf.values[i * field.channels]);
    }
  }
  for (const Tile& tile : field.tiles) include(range, tile.value.x);
  return range.x <= range.y ? range : glm::dvec2(0);
}

double active_percentile(const Field& field, double percent) {
  const auto known = field.active_percentiles.find(percent);
  if (known != field.active_percentiles.end()) return known->second;
  check_in_memory(field);
  return value_percentile(
      [&](const auto& take) {
        for (const Leaf& leaf : field.leaves)
          for (int i = 0; i < 512; ++i) {
            const glm::ivec3 voxel = leaf.origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
            if (inside(field.active_box, voxel)) take(leaf.values[i * field.channels], 1);
          }
        for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
      },
      percent);
}

}  // namespace psivox
