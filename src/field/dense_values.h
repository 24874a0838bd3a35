#pragma once

#include <algorithm>
#include <glm/common.hpp>

#include "psivox/leaf_values.h"

namespace psivox {

/// Writes the values of a box of voxels, z fastest, with the field's channels; 0 where none is
/// stored.
inline void write_dense(const Field& field, const Box& box, float* out) {
  const glm::ivec3 size = box.max - box.min + 1;
  const auto channels = std::size_t(field.channels);
  const auto index = [&](const glm::ivec3& at) {
    return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
           std::size_t(at.z);
  };
  std::fill_n(out, (index(size - 1) + 1) * channels, 0.0f);
  const auto fill = [&](const glm::ivec3& origin, int width, const auto& value) {
    const glm::ivec3 low = glm::max(origin, box.min);
    const glm::ivec3 high = glm::min(origin + width - 1, box.max);
    for (int x = low.x; x <= high.x; ++x)
      for (int y = low.y; y <= high.y; ++y)
        for (int z = low.z; z <= high.z; ++z) {
          const glm::ivec3 at(x, y, z);
          std::copy_n(value(at - origin), channels, out + index(at - box.min) * channels);
        }
  };
  for (const Tile& tile : field.tiles)
    fill(tile.origin, tile.width, [&](const glm::ivec3&) { return &tile.value.x; });
  for (const Leaf& leaf : field.leaves) {
    const OrderedValues values(field, leaf);
    fill(leaf.origin, 8, [&](const glm::ivec3& at) {
      return values.data() + std::size_t((at.x * 8 + at.y) * 8 + at.z) * channels;
    });
  }
}

}  // namespace psivox
