#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <unordered_set>

#include "field/block_map.h"
#include "field/leaf_values.h"
#include "psivox/field.h"

namespace psivox {

/// Finds a field's leaves and tiles by position. The field must outlive it.
class FieldIndex {
 public:
  /// Widths of tiles, coarse to fine; the last is also a leaf's.
  static constexpr std::array<int, 3> widths{4096, 128, 8};

  /// The origin of the cube of that width around a voxel.
  static glm::ivec3 cube_of(const glm::ivec3& voxel, int width) { return voxel & ~(width - 1); }

  explicit FieldIndex(const Field& field);

  const Field& field() const { return *field_; }

  /// 8^3 voxels. The strides between them are 0 where one value fills the block.
  struct Block {
    LeafValues values{};
    bool stored = false;  ///< in a leaf or a tile; else all are 0
    bool is_constant() const { return values.is_constant(); }

    /// The first channel of voxel (x, y, z), where i = (x * 8 + y) * 8 + z.
    float value(int i) const { return *values.at(leaf_voxel(i)); }
  };
  /// The block at `origin`, a multiple of 8. Tiles' values are the field's own.
  Block block(const glm::ivec3& origin) const;
  /// Value of a voxel; 0 where nothing is stored.
  glm::dvec3 at(const glm::ivec3& voxel) const;

  /// Trilinear interpolation at a point of index space; 0 outside the domain.
  glm::dvec3 at(const glm::dvec3& point) const;

  /// Whether the field has tiles of widths[level], or leaves of that width.
  bool has_width(int level) const { return has_width_[std::size_t(level)]; }

  /// The leaf at `origin`; null if there is none.
  const Leaf* leaf(const glm::ivec3& origin) const;

  /// Whether a leaf or a tile lies in the cube of widths[level] at `origin`, a multiple of that
  /// width.
  bool holds_any(int level, const glm::ivec3& origin) const;
  /// Whether a leaf or a tile that is narrower than the cube lies in it.
  bool holds_narrower(int level, const glm::ivec3& origin) const;

  /// Whether the cube of widths[level] at `origin` is one tile or leaf.
  bool is_one(int level, const glm::ivec3& origin) const;

  /// A cube of those widths that is one tile or leaf, or empty.
  struct Cube {
    Box voxels;
    Block block;
  };
  /// The widest one around a voxel.
  Cube cube(const glm::ivec3& voxel) const;

  /// How many points, from `point` on and `step` apart, have their nearest voxels in one empty cube
  /// of those widths; 0 if a leaf or a tile holds the first. `point` is in index space.
  std::size_t empty_steps(const glm::dvec3& point, const glm::dvec3& step) const;

  /// Whether a voxel is in a leaf or a tile.
  bool stores(const glm::ivec3& voxel) const { return cube(voxel).block.stored; }

 private:
  /// Null if there is none.
  const Tile* tile(int level, const glm::ivec3& origin) const;

  const Field* field_;
  BlockMap numbers_;  ///< of leaves and then of tiles, by their origins
  std::array<bool, 3> has_width_{};
  std::array<std::unordered_set<glm::ivec3, VoxelHash>, 2> occupied_;  ///< for the two wider ones
};

}  // namespace psivox
