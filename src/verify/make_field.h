#pragma once

#include <cstddef>
#include <functional>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "psivox/field.h"

namespace psivox {

/// A field of leaves that cover `active`. `write(voxel, out)` writes the `channels` floats of each
/// active voxel; the leaves' other voxels are 0.
inline Field make_field_of(const Box& active, int channels,
                           const std::function<void(const glm::ivec3&, float*)>& write,
                           const glm::dmat4& world_from_index) {
  Field field;
  field.name = "density";
  field.value_type = channels == 3 ? "vec3s" : "float";
  field.channels = channels;
  field.active_box = active;
  field.world_from_index = world_from_index;
  if (active.empty()) return field;
  const glm::ivec3 first(active.min.x >> 3, active.min.y >> 3, active.min.z >> 3);
  const glm::ivec3 last(active.max.x >> 3, active.max.y >> 3, active.max.z >> 3);
  const glm::ivec3 count = last - first + 1;
  const auto floats_per_leaf = std::size_t(512 * channels);
  const auto leaves = std::size_t(count.x) * std::size_t(count.y) * std::size_t(count.z);
  auto values = std::make_shared<std::vector<float>>(leaves * floats_per_leaf);
  float* out = values->data();
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y)
      for (int z = first.z; z <= last.z; ++z)
        field.leaves.push_back(
            {8 * glm::ivec3(x, y, z), values->data() + field.leaves.size() * floats_per_leaf});
  for (const Leaf& leaf : field.leaves) {
    for (int i = 0; i < 512; ++i, out += channels) {
      const glm::ivec3 voxel = leaf.origin + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
      const bool inside = voxel.x >= active.min.x && voxel.x <= active.max.x &&
                          voxel.y >= active.min.y && voxel.y <= active.max.y &&
                          voxel.z >= active.min.z && voxel.z <= active.max.z;
      if (!inside) continue;
      write(voxel, out);
      ++field.active_voxels;
    }
  }
  field.storage = std::move(values);
  return field;
}

inline Field make_field(const Box& active, const std::function<float(glm::ivec3)>& value,
                        const glm::dmat4& world_from_index = glm::dmat4(1.0)) {
  return make_field_of(
      active, 1, [&](const glm::ivec3& voxel, float* out) { *out = value(voxel); },
      world_from_index);
}

inline Field make_vector_field(const Box& active, const std::function<glm::vec3(glm::ivec3)>& value,
                               const glm::dmat4& world_from_index = glm::dmat4(1.0)) {
  return make_field_of(
      active, 3,
      [&](const glm::ivec3& voxel, float* out) {
        const glm::vec3 v = value(voxel);
        for (int c = 0; c < 3; ++c) out[c] = v[c];
      },
      world_from_index);
}

}  // namespace psivox
