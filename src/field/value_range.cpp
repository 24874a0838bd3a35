#include "field/value_range.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "field/lane_range.h"
#include "field/leaf_values.h"

namespace psivox {
namespace {

void include(glm::dvec2& range, float value) {
  range.x = std::min(range.x, double(value));
  range.y = std::max(range.y, double(value));
}

/// Calls take(value) for the first channel of the leaves' voxels in the active box.
template <typename Take>
void for_active(const Field& field, const Take& take) {
  for (const Leaf& leaf : field.leaves) {
    const LeafValues values = values_of(field, leaf);
    for (int i = 0; i < 512; ++i) {
      const glm::ivec3 voxel = leaf_voxel(i);
      if (field.active_box.contains(leaf.origin + voxel)) take(*values.at(voxel));
    }
  }
}

/// Of all values of all channels, and 0.
glm::dvec2 whole_range(const Field& field) {
  glm::dvec2 range = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, field.leaves.size(), 256), glm::dvec2(0),
      [&](const auto& some, glm::dvec2 found) {
        for (std::size_t n = some.begin(); n != some.end(); ++n) {
          constexpr std::size_t lanes = 64;
          LaneRange<lanes> of_leaf;
          const OrderedValues values(field, field.leaves[n]);
          for (std::size_t i = 0; i < values.size(); i += lanes) of_leaf.include(values.data() + i);
          include(found, of_leaf.least());
          include(found, of_leaf.greatest());
        }
        return found;
      },
      [](const glm::dvec2& a, const glm::dvec2& b) {
        return glm::dvec2(std::min(a.x, b.x), std::max(a.y, b.y));
      });
  for (const Tile& tile : field.tiles)
    for (int c = 0; c < field.channels; ++c) include(range, tile.value[c]);
  return range;
}

}  // namespace

glm::dvec2 stored_range(const Field& field) {
  return field.stored_range ? glm::dvec2(*field.stored_range) : whole_range(field);
}

double greatest_value(const Field& field) {
  return field.channels == 1 ? stored_range(field).y : whole_range(field).y;
}

glm::dvec2 active_range(const Field& field) {
  if (field.active_range) return glm::dvec2(*field.active_range);
  glm::dvec2 range(HUGE_VAL, -HUGE_VAL);
  for_active(field, [&](float value) { include(range, value); });
  for (const Tile& tile : field.tiles) include(range, tile.value.x);
  return range.x <= range.y ? range : glm::dvec2(0);
}

double active_percentile(const Field& field, double percent) {
  const auto known = field.active_percentiles.find(percent);
  if (known != field.active_percentiles.end()) return known->second;
  check_in_memory(field);
  return value_percentile(
      [&](const auto& take) {
        for_active(field, [&](float value) { take(value, 1); });
        for (const Tile& tile : field.tiles) take(tile.value.x, tile_voxels(tile));
      },
      percent);
}

}  // namespace psivox
