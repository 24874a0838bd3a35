#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "atlas/atlas.h"
#include "field/field_index.h"
#include "field/index_space.h"

namespace psivox::atlas {

/// Bricks found together: a single one, or many between wide tiles, whose blocks are equal. Along
/// each axis, the bricks of a cell of `width` voxels are divided into the last, whose apron lies in
/// the next cell, and the others. So pieces are disjoint.
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

  /// Throws Error(input) if a field is too wide for a page table.
  static void check_width(const Field& field);

  int channels() const { return field_.channels; }

  /// Blocks that a brick's 9^3 values come from, at the corners of a cube.
  using Neighbours = std::array<FieldIndex::Block, 8>;
  Neighbours neighbours(const glm::ivec3& brick) const;

  /// The least number of a leaf that a brick has values of; their count if it has none.
  std::size_t first_leaf(const glm::ivec3& brick) const;

  /// Copies a brick's values, z fastest, `channels` interleaved.
  void gather(const Neighbours& from, float* values) const;

  /// Bricks that a leaf or a tile reaches into, each once. Bricks of one piece have equal
  /// neighbours, all constant if there are several.
  std::vector<Piece> candidates() const;

 private:
  /// Whether the bricks of a piece have equal neighbours. `level` is that of its width.
  bool alike(const glm::ivec3& first, int level) const;

  const Field& field_;
  FieldIndex index_;
};

/// Candidate bricks and their kind.
struct Candidate {
  Box bricks;
  EntryKind kind = EntryKind::empty;
  glm::vec3 value{0};
};

/// Least and greatest first channel of a brick's values.
ValueRange value_range(const BrickSource::Neighbours& from, int channels);

/// The bricks of a region that leaves and tiles reach, and with a margin those beside them. If they
/// are all kept, what options.visible says does not matter.
std::vector<Candidate> find_candidates(const BrickSource& source, const AtlasOptions& options,
                                       const Box& region, bool keep_all);

/// Least and greatest of a scalar brick's values in a box, both ends inclusive.
inline ValueRange range_in_brick(const float* values, const glm::ivec3& first,
                                 const glm::ivec3& last) {
  ValueRange range{HUGE_VALF, -HUGE_VALF};
  for_points({first, last}, [&](const glm::ivec3& at) {
    const float value = values[(at.x * brick_values + at.y) * brick_values + at.z];
    range = {std::min(range.min, value), std::max(range.max, value)};
  });
  return range;
}

}  // namespace psivox::atlas
