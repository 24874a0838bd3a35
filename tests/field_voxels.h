#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <unordered_map>
#include <vector>

#include "atlas/atlas.h"
#include "field/index_space.h"
#include "psivox/field.h"

namespace psivox {

/// A field's values as field.h documents them: a map's look-up for each voxel. It shares no code
/// with the program, and checks that no leaf or tile comes twice.
class FieldVoxels {
 public:
  explicit FieldVoxels(const Field& field) : channels_(field.channels) {
    for (const Leaf& leaf : field.leaves)
      EXPECT_TRUE(leaves_.emplace(leaf.origin, leaf.values).second) << "leaf twice";
    for (const Tile& tile : field.tiles) {
      EXPECT_NE(tile.value, glm::vec3(0));
      EXPECT_TRUE(tiles_[tile.width].emplace(tile.origin, tile.value).second) << "tile twice";
    }
  }

  /// One channel in x, or three.
  glm::vec3 operator()(const glm::ivec3& voxel) const {
    if (const auto leaf = leaves_.find(voxel & ~7); leaf != leaves_.end()) {
      const glm::ivec3 d = voxel & 7;
      const float* v = leaf->second + ((d.x * 8 + d.y) * 8 + d.z) * channels_;
      return channels_ == 3 ? glm::vec3(v[0], v[1], v[2]) : glm::vec3(v[0], 0, 0);
    }
    for (const auto& [width, tiles] : tiles_)
      if (const auto tile = tiles.find(voxel & ~(width - 1)); tile != tiles.end())
        return channels_ == 3 ? tile->second : glm::vec3(tile->second.x, 0, 0);
    return glm::vec3(0);
  }
  double voxel(const glm::ivec3& at, int channel) const { return double((*this)(at)[channel]); }

  double trilinear(const glm::dvec3& at, int channel) const {
    const glm::dvec3 cell = glm::floor(at), f = at - cell;
    double value = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 d(corner & 1, corner >> 1 & 1, corner >> 2);
      const glm::dvec3 w = glm::mix(1.0 - f, f, glm::dvec3(d));
      value += w.x * w.y * w.z * voxel(glm::ivec3(cell) + d, channel);
    }
    return value;
  }

  /// Whether the 9^3 values of a brick are all 0, all equal, or neither.
  EntryKind kind(const glm::ivec3& brick) const {
    const glm::vec3 first = (*this)(brick * 8);
    bool equal = true;
    for_points({8 * brick, 8 * brick + 8},
               [&](const glm::ivec3& v) { equal &= (*this)(v) == first; });
    if (!equal) return EntryKind::brick;
    return first == glm::vec3(0) ? EntryKind::empty : EntryKind::constant;
  }

 private:
  struct Hash {
    std::size_t operator()(const glm::ivec3& v) const {
      const glm::uvec3 u(v);
      return std::size_t(u.x) * 73856093 ^ std::size_t(u.y) * 19349663 ^
             std::size_t(u.z) * 83492791;
    }
  };

  int channels_;
  std::unordered_map<glm::ivec3, const float*, Hash> leaves_;
  std::map<int, std::unordered_map<glm::ivec3, glm::vec3, Hash>> tiles_;  ///< by their width
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
    value[static_cast<int>(c)] = atlas.texels[(entry.payload * 729 + texel) * channels + c];
  }
  return value;
}

}  // namespace psivox
