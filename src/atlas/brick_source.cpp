#include "atlas/brick_source.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <set>
#include <string>

#include "base/memory.h"
#include "psivox/error.h"

namespace psivox::atlas {
namespace {

/// `width` is a power of two.
glm::ivec3 floor_divide(const glm::ivec3& a, int width) {
  return a >> std::countr_zero(unsigned(width));
}

}  // namespace

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

BrickSource::BrickSource(const Field& field) : field_(field), leaves_(field.leaves.size()) {
  check_in_memory(field);
  for (std::size_t i = 0; i < field.leaves.size(); ++i)
    leaves_.insert(field.leaves[i].origin >> 3, std::int32_t(i));
  // a tile of OpenVDB is as wide as 16 or 32 narrower ones
  std::set<int, std::greater<>> widths;
  for (const Tile& tile : field.tiles)
    if (tile.width > brick_cells) widths.insert({tile.width, std::min(tile.width, 128)});
  for (const int width : widths) levels_.push_back({width});
  const auto occupy = [&](const glm::ivec3& origin, int width) {
    for (Level& level : levels_)
      if (level.width > width) level.narrower.insert(floor_divide(origin, level.width), 0);
  };
  for (const Leaf& leaf : field.leaves) occupy(leaf.origin, brick_cells);
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    const Tile& tile = field.tiles[i];
    occupy(tile.origin, tile.width);
    if (tile.width == brick_cells)
      narrow_tiles_.insert(tile.origin >> 3, std::int32_t(i));
    else
      for (Level& level : levels_)
        if (level.width == tile.width)
          level.tiles.insert(floor_divide(tile.origin, tile.width), std::int32_t(i));
  }
}

void BrickSource::check_width(const Field& field) {
  constexpr std::int64_t widest_box = (std::int64_t{1} << 24) - 16;  // [voxels], see BlockMap
  for (int axis = 0; axis < 3; ++axis)
    if (std::int64_t(field.active_box.max[axis]) - field.active_box.min[axis] > widest_box)
      throw Error(ExitCode::input, "grid '" + field.name + "' is more than " +
                                       std::to_string(widest_box) + " voxels wide; resample it");
}

Block BrickSource::block(const glm::ivec3& at) const {
  if (leaves_.size() > 0)
    if (const auto i = leaves_.find(at); i != BlockMap::none)
      return {values_of(field_, field_.leaves[std::size_t(i)]), {}};
  if (narrow_tiles_.size() > 0)
    if (const auto i = narrow_tiles_.find(at); i != BlockMap::none)
      return {{}, field_.tiles[std::size_t(i)].value};
  for (const Level& level : levels_)
    if (const auto i = level.tiles.find(floor_divide(at, level.width / brick_cells));
        i != BlockMap::none)
      return {{}, field_.tiles[std::size_t(i)].value};
  return {};
}

bool BrickSource::Neighbours::are_constant() const {
  return std::all_of(std::begin(blocks), std::end(blocks), std::mem_fn(&Block::is_constant));
}

BrickSource::Neighbours BrickSource::neighbours(const glm::ivec3& brick) const {
  Neighbours result;
  // most blocks lie in the wide tile, or beside all, of the one before them along z
  const bool wide_alone = leaves_.size() == 0 && narrow_tiles_.size() == 0;
  constexpr int narrowest = 128 / brick_cells;
  const bool one_along_z = wide_alone && (brick.z & (narrowest - 1)) != narrowest - 1;
  for (int i = 0; i < 8; ++i)
    result.blocks[i] = i % 2 == 1 && one_along_z
                           ? result.blocks[i - 1]
                           : block(brick + glm::ivec3(i >> 2, i >> 1 & 1, i & 1));
  return result;
}

std::size_t BrickSource::first_leaf(const glm::ivec3& brick) const {
  std::size_t first = field_.leaves.size();
  for (int i = 0; i < 8; ++i) {
    const std::int32_t leaf = leaves_.find(brick + glm::ivec3(i >> 2, i >> 1 & 1, i & 1));
    if (leaf != BlockMap::none) first = std::min(first, std::size_t(leaf));
  }
  return first;
}

void BrickSource::gather(const Neighbours& from, float* values) const {
  const int channels = field_.channels;
  const auto copy = [&](const Block& block, int x, int y, int count, float* to) {
    const float* row = block.row(x & 7, y & 7, count, channels, to);
    if (row == to) return;
    if (channels == 1 && count == 8)
      std::memcpy(to, row, 8 * sizeof(float));  // of a size that the compiler knows
    else
      for (int i = 0; i < count * channels; ++i) to[i] = row[i];
  };
  for (int x = 0; x < brick_values; ++x)
    for (int y = 0; y < brick_values; ++y) {
      const Block* pair = from.blocks + ((x >> 3) * 2 + (y >> 3)) * 2;
      float* to = values + (x * brick_values + y) * brick_values * channels;
      copy(pair[0], x, y, 8, to);
      copy(pair[1], x, y, 1, to + 8 * channels);
    }
}

bool BrickSource::alike(const glm::ivec3& first, const Level& level) const {
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 at = first + glm::ivec3(i >> 2, i >> 1 & 1, i & 1);
    if (level.narrower.find(floor_divide(at, level.width / brick_cells)) != BlockMap::none)
      return false;
  }
  return true;
}

std::vector<Piece> BrickSource::candidates() const {
  std::vector<Piece> result;
  result.reserve(field_.leaves.size() * 5 / 4);
  BlockMap seen(field_.leaves.size() + field_.leaves.size() / 2);
  const auto add = [&](const glm::ivec3& first, int width) {
    const auto next = std::int32_t(result.size());
    if (seen.insert(first, next) != next) return;
    if (result.size() == result.capacity()) check_growth(field_, result.size());
    result.push_back({first, width});
  };
  const auto add_lower = [&](const glm::ivec3& block) {
    for (int i = 0; i < 8; ++i) add(block - glm::ivec3(i >> 2, i >> 1 & 1, i & 1), brick_cells);
  };
  // a piece as wide as a level's tiles, or the narrower ones in it
  const auto add_alike = [&](const auto& self, const glm::ivec3& first, std::size_t level) -> void {
    if (level == levels_.size()) return add(first, brick_cells);
    const Piece piece{first, levels_[level].width};
    if (alike(first, levels_[level])) return add(first, piece.width);
    const int narrower = level + 1 < levels_.size() ? levels_[level + 1].width : brick_cells;
    const Box box = piece.bricks();
    const auto next = [&](int at, int axis) {
      glm::ivec3 in = first;
      in[axis] = at;
      return Piece{in, narrower}.bricks().max[axis] + 1;
    };
    for (int x = box.min.x; x <= box.max.x; x = next(x, 0))
      for (int y = box.min.y; y <= box.max.y; y = next(y, 1))
        for (int z = box.min.z; z <= box.max.z; z = next(z, 2)) self(self, {x, y, z}, level + 1);
  };
  for (const Leaf& leaf : field_.leaves) add_lower(leaf.origin >> 3);
  for (const Tile& tile : field_.tiles) {
    const glm::ivec3 lo = tile.origin >> 3;
    const int n = tile.width / brick_cells;
    if (n == 1) {
      add_lower(lo);
      continue;
    }
    std::size_t level = 0;
    while (levels_[level].width != tile.width) ++level;
    // the layer below the tile, and the tile's last layer, whose apron lies beyond the tile
    for (const int x : {-1, 0, n - 1})
      for (const int y : {-1, 0, n - 1})
        for (const int z : {-1, 0, n - 1})
          if (x != 0 || y != 0 || z != 0) add_alike(add_alike, lo + glm::ivec3(x, y, z), level);
  }
  return result;
}

std::vector<int> BrickSource::widths() const {
  std::vector<int> result{brick_cells};
  for (const Level& level : levels_) result.push_back(level.width);
  return result;
}

std::vector<BrickSource::ConstantBox> BrickSource::wide_tiles() const {
  std::vector<ConstantBox> result;
  for (const Tile& tile : field_.tiles) {
    const int n = tile.width / brick_cells;
    const glm::ivec3 lo = tile.origin >> 3;
    if (n > 1) result.push_back({lo, lo + (n - 2), tile.value});
  }
  return result;
}

}  // namespace psivox::atlas
