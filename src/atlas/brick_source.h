#pragma once

#include <algorithm>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/block_map.h"
#include "field/index_space.h"
#include "field/leaf_values.h"

namespace psivox::atlas {

/// 8^3 voxels of a field: a leaf's values, or one value.
struct Block {
  LeafValues values{};  ///< without any: `constant` everywhere
  glm::vec3 constant{0};

  bool is_constant() const { return !values.first; }
  /// The first `count` voxels of the row (x, y), `channels` interleaved: in place, or written to
  /// `room`.
  const float* row(int x, int y, int count, int channels, float* room) const;
};

inline const float* Block::row(int x, int y, int count, int channels, float* room) const {
  if (is_constant()) {
    for (int i = 0; i < count * channels; ++i) room[i] = constant[i % channels];
    return room;
  }
  const float* from = values.at({x, y, 0});
  const Strides& strides = values.strides;
  if (strides.z == channels && strides.channel == 1) return from;
  for (int z = 0; z < count; ++z, from += strides.z)
    for (int c = 0; c < channels; ++c) room[z * channels + c] = from[c * strides.channel];
  return room;
}

/// Bricks that are found as one: a single one, or many between wide tiles whose blocks are equal.
/// Along each axis cells of `width` voxels are split into their last brick, whose apron lies in the
/// next cell, and the others, so that pieces are disjoint.
struct Piece {
  glm::ivec3 first;  ///< brick
  int width = brick_cells;

  /// The piece's bricks in a region.
  Box bricks(const Box& region = everywhere) const;
  /// The piece of a width that holds a brick.
  static Piece at(const glm::ivec3& brick, int width);
};

/// Finds the voxels of a field by block and puts them together into bricks.
class BrickSource {
 public:
  explicit BrickSource(const Field& field);

  /// Throws Error(input) if a field is too wide for its maps of blocks.
  static void check_width(const Field& field);

  int channels() const { return field_.channels; }

  /// Block of voxels [8 at, 8 at + 8).
  Block block(const glm::ivec3& at) const;

  /// Blocks that a brick's 9^3 values come from: index (x*2 + y)*2 + z, 1 on the + side.
  struct Neighbours {
    Block blocks[8];

    bool are_constant() const;
  };
  Neighbours neighbours(const glm::ivec3& brick) const;

  /// The least number of a leaf that a brick has values of; their count if it has none.
  std::size_t first_leaf(const glm::ivec3& brick) const;

  /// Copies a brick's values, z fastest, `channels` interleaved.
  void gather(const Neighbours& from, float* values) const;

  /// Bricks that a leaf or a tile reaches into, each once, without those inside a wide tile, whose
  /// values are all the tile's (see wide_tiles). Bricks of one piece have equal neighbours, all
  /// constant if there are several.
  std::vector<Piece> candidates() const;

  /// Boxes of bricks whose values are all one tile's.
  struct ConstantBox {
    glm::ivec3 min, max;  ///< bricks, inclusive
    glm::vec3 value;
  };
  std::vector<ConstantBox> wide_tiles() const;
  /// Widths of pieces: 8 voxels, and the widths of wide tiles.
  std::vector<int> widths() const;

 private:
  /// Tiles of one width, and what is narrower than they are.
  struct Level {
    int width;            ///< [voxels]
    BlockMap tiles{};     ///< numbers, by cells of that width
    BlockMap narrower{};  ///< cells that hold a leaf or a narrower tile
  };
  /// Whether the bricks of a piece have equal neighbours. `level` counts from the widest.
  bool alike(const glm::ivec3& first, const Level& level) const;

  const Field& field_;
  BlockMap leaves_;
  BlockMap narrow_tiles_;
  std::vector<Level> levels_;  ///< of wide tiles, the widest first
};

/// Least and greatest of a scalar brick's values in a box, both ends inclusive.
inline ValueRange range_in_brick(const float* values, const glm::ivec3& first,
                                 const glm::ivec3& last) {
  ValueRange range{HUGE_VALF, -HUGE_VALF};
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y)
      for (int z = first.z; z <= last.z; ++z) {
        const float value = values[(x * brick_values + y) * brick_values + z];
        range = {std::min(range.min, value), std::max(range.max, value)};
      }
  return range;
}

}  // namespace psivox::atlas
