#include "atlas/brick_source.h"

#include <algorithm>
#include <cstdint>
#include <glm/vector_relational.hpp>
#include <limits>
#include <string>

#include "base/memory.h"
#include "field/block_map.h"
#include "psivox/error.h"

namespace psivox::atlas {
/// Throws Error(memory) if a list of pieces that doubles would take more than what is free.
static void check_growth(const Field& field, std::size_t count) {
  constexpr std::uint64_t planned = 128;  // of a piece: in the list, in maps, with its kind [bytes]
  constexpr std::size_t few = std::size_t{1} << 22;
  if (const std::uint64_t free = available_memory();
      count > few && free > 0 && 2 * count * planned > free)
    throw Error(ExitCode::memory,
                "grid '" + field.name + "' has more than " + std::to_string(count) +
                    " bricks beside leaves and tiles, more than there is memory for");
}

Box Piece::bricks(const Box& region) const {
  const int last = width / brick_cells - 1;
  Box box{first, first};
  for (int axis = 0; axis < 3; ++axis)
    if ((first[axis] & last) != last) box.max[axis] += last - 1;
  return common(box, region);
}

Piece Piece::at(const glm::ivec3& brick, int width) {
  const int last = width / brick_cells - 1;
  Piece piece{brick, width};
  for (int axis = 0; axis < 3; ++axis)
    if ((brick[axis] & last) != last) piece.first[axis] &= ~last;
  return piece;
}

BrickSource::BrickSource(const Field& field) : field_(field), index_(field) {}

void BrickSource::check_width(const Field& field) {
  constexpr std::int64_t widest_box = (std::int64_t{1} << 24) - 16;  // [voxels]: skips are ints
  for (int axis = 0; axis < 3; ++axis)
    if (std::int64_t(field.active_box.max[axis]) - field.active_box.min[axis] > widest_box)
      throw Error(ExitCode::input, "grid '" + field.name + "' is more than " +
                                       std::to_string(widest_box) + " voxels wide; resample it");
}

BrickSource::Neighbours BrickSource::neighbours(const glm::ivec3& brick) const {
  Neighbours result;
  // most blocks lie in the wide tile, or beside all, of the one before them along z
  constexpr int narrowest = 128 / brick_cells;
  const bool one_along_z = !index_.has_width(2) && (brick.z & (narrowest - 1)) != narrowest - 1;
  for (int i = 0; i < 8; ++i) {
    const auto at = std::size_t(i);
    result[at] =
        i % 2 == 1 && one_along_z ? result[at - 1] : index_.block(8 * (brick + cube_corner(i)));
  }
  return result;
}

std::size_t BrickSource::first_leaf(const glm::ivec3& brick) const {
  std::size_t first = field_.leaves.size();
  for (int i = 0; i < 8; ++i)
    if (const Leaf* leaf = index_.leaf(8 * (brick + cube_corner(i))))
      first = std::min(first, std::size_t(leaf - field_.leaves.data()));
  return first;
}

void BrickSource::gather(const Neighbours& from, float* values) const {
  const int channels = field_.channels;
  for (int x = 0; x < brick_values; ++x)
    for (int y = 0; y < brick_values; ++y) {
      const auto pair = std::size_t((x >> 3) * 2 + (y >> 3)) * 2;
      float* to = values + (x * brick_values + y) * brick_values * channels;
      from[pair].values.copy_row(x & 7, y & 7, 8, channels, to);
      from[pair + 1].values.copy_row(x & 7, y & 7, 1, channels, to + 8 * channels);
    }
}

bool BrickSource::alike(const glm::ivec3& first, int level) const {
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 voxel = 8 * (first + cube_corner(i));
    const int width = FieldIndex::widths[std::size_t(level)];
    if (index_.holds_narrower(level, FieldIndex::cube_of(voxel, width))) return false;
  }
  return true;
}

std::vector<Piece> BrickSource::candidates() const {
  std::vector<Piece> result;
  result.reserve(field_.leaves.size() * 5 / 4);
  BlockMap seen(field_.leaves.size() + field_.leaves.size() / 2);
  // below a tile at the least integer no voxel has a place
  const auto exists = [](const glm::ivec3& first) {
    constexpr int least = std::numeric_limits<int>::min() / brick_cells;
    return glm::all(glm::greaterThanEqual(first, glm::ivec3(least)));
  };
  const auto add = [&](const glm::ivec3& first, int width) {
    if (!exists(first)) return;
    const auto next = std::int32_t(result.size());
    if (seen.insert(first, next) != next) return;
    if (result.size() == result.capacity()) check_growth(field_, result.size());
    result.push_back({first, width});
  };
  const auto add_lower = [&](const glm::ivec3& block) {
    for (int i = 0; i < 8; ++i) add(block - cube_corner(i), brick_cells);
  };
  // a piece as wide as a level's tiles, or the narrower ones in it
  constexpr auto& widths = FieldIndex::widths;
  const auto add_alike = [&](const auto& self, const glm::ivec3& first, std::size_t level) -> void {
    if (!exists(first)) return;
    const Piece piece{first, widths[level]};
    if (piece.width == brick_cells || alike(first, int(level))) return add(first, piece.width);
    const Box box = piece.bricks();
    const auto next = [&](int at, int axis) {
      glm::ivec3 in = first;
      in[axis] = at;
      return Piece{in, widths[level + 1]}.bricks().max[axis] + 1;
    };
    for (int x = box.min.x; x <= box.max.x; x = next(x, 0))
      for (int y = box.min.y; y <= box.max.y; y = next(y, 1))
        for (int z = box.min.z; z <= box.max.z; z = next(z, 2)) self(self, {x, y, z}, level + 1);
  };
  for (const Tile& tile : field_.tiles)
    if (tile.width > brick_cells) add(tile.origin >> 3, tile.width);
  for (const Leaf& leaf : field_.leaves) add_lower(leaf.origin >> 3);
  for (const Tile& tile : field_.tiles) {
    const glm::ivec3 lo = tile.origin >> 3;
    const int n = tile.width / brick_cells;
    if (n == 1) {
      add_lower(lo);
      continue;
    }
    const auto level = std::size_t(std::ranges::find(widths, tile.width) - widths.begin());
    // the layer below the tile, and the tile's last layer, whose apron lies beyond the tile
    for (const int x : {-1, 0, n - 1})
      for (const int y : {-1, 0, n - 1})
        for (const int z : {-1, 0, n - 1})
          if (x != 0 || y != 0 || z != 0) add_alike(add_alike, lo + glm::ivec3(x, y, z), level);
  }
  return result;
}

}  // namespace psivox::atlas
