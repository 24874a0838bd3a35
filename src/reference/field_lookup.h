#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/field.h"
#include "psivox/leaf_values.h"

namespace psivox {

/// The 8x8x8 cells from voxel 8 * key on, with the 9x9x9 voxels at their corners. A cell has the
/// coordinates of its smallest voxel. Voxel 8 of an axis lies in the next leaf, so a block reads up
/// to eight leaves.
struct CellBlock {
  glm::ivec3 key{0};
  /// The values of voxel block key + (dx,dy,dz) are at 4 dx + 2 dy + dz. Strides are 0 if one value
  /// fills the block.
  std::array<LeafValues, 8> values{};
  int channels = 1;
  bool empty = true;  ///< all 9x9x9 voxels are 0 in every channel

  /// Value of one voxel, each coordinate relative to the block, 0 to 8.
  float value(const glm::ivec3& voxel, int channel) const {
    const int block = 4 * (voxel.x >> 3) + 2 * (voxel.y >> 3) + (voxel.z >> 3);
    const LeafValues& own = values[static_cast<std::size_t>(block)];
    return own.at(voxel & 7)[channel * own.strides.channel];
  }

  /// The eight voxels around a cell of this block (in index space), at 4 dx + 2 dy + dz.
  std::array<double, 8> corners(const glm::ivec3& cell, int channel) const {
    const glm::ivec3 local = cell - 8 * key;
    std::array<double, 8> c;
    for (int i = 0; i < 8; ++i) {
      c[static_cast<std::size_t>(i)] =
          value(local + glm::ivec3(i >> 2, (i >> 1) & 1, i & 1), channel);
    }
    return c;
  }
};

/// Maps block coordinates to a number, by open addressing.
class BlockMap {
 public:
  static constexpr std::uint32_t none = ~0u;

  void insert(const glm::ivec3& key, std::uint32_t value);
  std::uint32_t find(const glm::ivec3& key) const;  ///< `none` if it is missing
  bool empty() const { return size_ == 0; }

 private:
  struct Slot {
    glm::ivec3 key{0};
    std::uint32_t value = none;
  };
  std::size_t slot_of(const glm::ivec3& key) const;
  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

/// Finds voxels of a field by their coordinates. It reads the field's leaves and tiles in place, so
/// the field must outlive it and must not move.
class FieldLookup {
 public:
  /// Widths at which a walk may skip cells, coarse to fine; the last is a CellBlock's.
  static constexpr std::array<int, 3> widths{4096, 128, 8};

  explicit FieldLookup(const Field& field);

  const Field& field() const { return *field_; }

  CellBlock cell_block(const glm::ivec3& key) const;

  /// False only if every corner of the cells [w key, w key + w), w = widths[level], is 0.
  bool may_hold_values(int level, const glm::ivec3& key) const;

  /// Largest magnitude of a value in any channel.
  double max_magnitude() const;

 private:
  struct TileClass {
    int log2_width;
    BlockMap tiles;  ///< origin / width -> place in Field::tiles
  };

  const Field* field_;
  BlockMap leaves_;                   ///< origin / 8 -> place in Field::leaves
  std::vector<TileClass> tiles_;      ///< one for each width that occurs
  std::array<BlockMap, 2> occupied_;  ///< cells that touch a leaf or a narrower tile, by level
};

/// CellBlocks that one thread has used recently.
class BlockCache {
 public:
  explicit BlockCache(const FieldLookup& lookup);

  /// Valid until the next call.
  const CellBlock& at(const glm::ivec3& key);

 private:
  const FieldLookup* lookup_;
  std::vector<CellBlock> blocks_;
};

}  // namespace psivox
