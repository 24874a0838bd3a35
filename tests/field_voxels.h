#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <set>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "atlas/atlas.h"
#include "psivox/field.h"

namespace psivox {

/// A field's values voxel by voxel, by a hash map of leaves and a search of tiles. Atlases are
/// compared with it; it shares no code with them.
class FieldVoxels {
 public:
  explicit FieldVoxels(const Field& field) : field_(field) {
    for (const Leaf& leaf : field.leaves) leaves_[key(leaf.origin >> 3)] = leaf.values;
  }

  glm::vec3 operator()(const glm::ivec3& voxel) const {
    if (const auto leaf = leaves_.find(key(voxel >> 3)); leaf != leaves_.end()) {
      const glm::ivec3 d = voxel & 7;
      const float* v = leaf->second + ((d.x * 8 + d.y) * 8 + d.z) * field_.channels;
      return field_.channels == 3 ? glm::vec3(v[0], v[1], v[2]) : glm::vec3(v[0], 0, 0);
    }
    for (const Tile& tile : field_.tiles) {
      const glm::ivec3 d = voxel - tile.origin;
      if (d.x < 0 || d.y < 0 || d.z < 0 || d.x >= tile.width || d.y >= tile.width ||
          d.z >= tile.width)
        continue;
      return field_.channels == 3 ? tile.value : glm::vec3(tile.value.x, 0, 0);
    }
    return glm::vec3(0);
  }

  /// Whether the 9^3 values of a brick are all 0, all equal, or neither.
  EntryKind kind(const glm::ivec3& brick) const {
    const glm::vec3 first = (*this)(brick * 8);
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y)
        for (int z = 0; z < 9; ++z)
          if ((*this)(brick * 8 + glm::ivec3(x, y, z)) != first) return EntryKind::brick;
    return first == glm::vec3(0) ? EntryKind::empty : EntryKind::constant;
  }

 private:
  static std::size_t key(const glm::ivec3& block) {
    const auto part = [](int v) { return static_cast<std::size_t>(v + (1 << 20)); };
    return (part(block.x) << 42) | (part(block.y) << 21) | part(block.z);
  }

  const Field& field_;
  std::unordered_map<std::size_t, const float*> leaves_;
};

/// The entry of a page table that covers a voxel, and the box of voxels that it represents. Written
/// independently, from the documentation in atlas.h and shaders/atlas.glsl.
struct PageEntry {
  EntryKind kind;
  std::uint32_t payload;
  Box box;  ///< the entry's own
  int width;
};

inline PageEntry page_entry(const PageTable& pages, const glm::ivec3& voxel) {
  int width = 8;
  for (int level = 1; level < pages.levels; ++level) width *= 8;
  glm::ivec3 local = voxel - pages.min, size = pages.top_size, origin = pages.min;
  std::size_t base = 0;
  while (true) {
    const glm::ivec3 at = local / width;
    const std::size_t index = base +
                              (static_cast<std::size_t>(at.x) * static_cast<std::size_t>(size.y) +
                               static_cast<std::size_t>(at.y)) *
                                  static_cast<std::size_t>(size.z) +
                              static_cast<std::size_t>(at.z);
    const std::uint32_t entry = pages.entries.at(index);
    origin += at * width;
    if (entry_kind(entry) != EntryKind::child)
      return {entry_kind(entry), entry_payload(entry), {origin, origin + (width - 1)}, width};
    base = entry_payload(entry);
    local -= at * width;
    size = glm::ivec3(8);
    width /= 8;
  }
}

/// Value of the atlas at a cell's corner: cell + corner, corner in {0, 1}^3.
inline glm::vec3 atlas_value(const BrickAtlas& atlas, const PageEntry& entry,
                             const glm::ivec3& voxel) {
  const auto channels = static_cast<std::size_t>(atlas.channels);
  glm::vec3 value(0);
  if (entry.kind == EntryKind::empty) return value;
  for (std::size_t c = 0; c < channels; ++c) {
    if (entry.kind == EntryKind::constant) {
      value[static_cast<int>(c)] = atlas.constants.at(entry.payload * channels + c);
      continue;
    }
    const glm::ivec3 d = voxel - entry.box.min;
    const auto texel = static_cast<std::size_t>((d.x * 9 + d.y) * 9 + d.z);
    value[static_cast<int>(c)] = atlas.texels32[(entry.payload * 729 + texel) * channels + c];
  }
  return value;
}

}  // namespace psivox
