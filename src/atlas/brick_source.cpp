#include "atlas/brick_source.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "psivox/error.h"

namespace psivox::atlas {
namespace {

/// `width` is a power of two.
glm::ivec3 floor_divide(const glm::ivec3& a, int width) {
  return a >> std::countr_zero(unsigned(width));
}

}  // namespace

const float* Block::row(int x, int y, int count, int channels, float* room) const {
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

BrickSource::BrickSource(const Field& field) : field_(field), leaves_(field.leaves.size()) {
  check_in_memory(field);
  for (std::size_t i = 0; i < field.leaves.size(); ++i)
    leaves_.insert(field.leaves[i].origin >> 3, std::int32_t(i));
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    const Tile& tile = field.tiles[i];
    if (tile.width == brick_cells) {
      narrow_tiles_.insert(tile.origin >> 3, std::int32_t(i));
      continue;
    }
    auto map = std::find_if(wide_maps_.begin(), wide_maps_.end(),
                            [&](const auto& entry) { return entry.first == tile.width; });
    if (map == wide_maps_.end()) map = wide_maps_.insert(map, {tile.width, BlockMap()});
    map->second.insert(floor_divide(tile.origin, tile.width), std::int32_t(i));
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
  for (const auto& [width, map] : wide_maps_)
    if (const auto i = map.find(floor_divide(at * brick_cells, width)); i != BlockMap::none)
      return {{}, field_.tiles[std::size_t(i)].value};
  return {};
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

std::vector<glm::ivec3> BrickSource::candidates() const {
  std::vector<glm::ivec3> result;
  result.reserve(field_.leaves.size() * 5 / 4);
  BlockMap seen(field_.leaves.size() + field_.leaves.size() / 2);
  const auto add = [&](const glm::ivec3& brick) {
    const auto next = std::int32_t(result.size());
    if (seen.insert(brick, next) == next) result.push_back(brick);
  };
  const auto add_lower = [&](const glm::ivec3& block) {
    for (int i = 0; i < 8; ++i) add(block - glm::ivec3(i >> 2, i >> 1 & 1, i & 1));
  };
  for (const Leaf& leaf : field_.leaves) add_lower(leaf.origin >> 3);
  for (const Tile& tile : field_.tiles) {
    const glm::ivec3 lo = tile.origin >> 3;
    const int n = tile.width / brick_cells;
    if (n == 1) {
      add_lower(lo);
      continue;
    }
    // the layer below the tile, and the tile's last layer, whose apron lies beyond the tile
    for (int x = -1; x < n; ++x)
      for (int y = -1; y < n; ++y) {
        const bool side = x == -1 || x == n - 1 || y == -1 || y == n - 1;
        for (int z = -1; z < n; z += side || z == n - 1 ? 1 : n) add(lo + glm::ivec3(x, y, z));
      }
  }
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
