#include "field_lookup.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <climits>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

namespace psivox {
namespace {

constexpr std::array<float, 3> zeros{0, 0, 0};
constexpr Strides of_one_value{0, 0, 0, 1};

int log2_of(int width) { return std::countr_zero(static_cast<unsigned>(width)); }

glm::ivec3 shifted(const glm::ivec3& v, int bits) {
  return {v.x >> bits, v.y >> bits, v.z >> bits};
}

glm::ivec3 neighbour(int i) { return {i >> 2, (i >> 1) & 1, i & 1}; }

bool all_zero(const CellBlock& block) {
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      for (int z = 0; z <= 8; ++z)
        for (int c = 0; c < block.channels; ++c)
          if (block.value({x, y, z}, c) != 0) return false;
  return true;
}

}  // namespace

std::size_t BlockMap::slot_of(const glm::ivec3& key) const {
  std::uint64_t h = static_cast<std::uint32_t>(key.x) * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 32) ^ static_cast<std::uint32_t>(key.y)) * 0xBF58476D1CE4E5B9ull;
  h = (h ^ (h >> 32) ^ static_cast<std::uint32_t>(key.z)) * 0x94D049BB133111EBull;
  std::size_t i = static_cast<std::size_t>(h >> 20) & (slots_.size() - 1);
  while (slots_[i].value != none && slots_[i].key != key) i = (i + 1) & (slots_.size() - 1);
  return i;
}

void BlockMap::insert(const glm::ivec3& key, std::uint32_t value) {
  if (2 * (size_ + 1) > slots_.size()) {
    std::vector<Slot> old(std::max<std::size_t>(16, 2 * slots_.size()));
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.value != none) slots_[slot_of(slot.key)] = slot;
  }
  Slot& slot = slots_[slot_of(key)];
  if (slot.value == none) ++size_;
  slot = {key, value};
}

std::uint32_t BlockMap::find(const glm::ivec3& key) const {
  return slots_.empty() ? none : slots_[slot_of(key)].value;
}

FieldLookup::FieldLookup(const Field& field) : field_(&field) {
  check_in_memory(field);
  // Voxels [o, o + w) are corners of the blocks of W cells from (o - 1) / W to (o + w - 1) / W.
  auto occupy = [this](const glm::ivec3& origin, int width) {
    for (std::size_t level = 0; level < occupied_.size(); ++level) {
      if (width >= widths[level]) continue;
      const int bits = log2_of(widths[level]);
      const glm::ivec3 first = shifted(origin - 1, bits), last = shifted(origin + width - 1, bits);
      for (int x = first.x; x <= last.x; ++x)
        for (int y = first.y; y <= last.y; ++y)
          for (int z = first.z; z <= last.z; ++z) occupied_[level].insert({x, y, z}, 0);
    }
  };
  for (std::size_t i = 0; i < field.leaves.size(); ++i) {
    leaves_.insert(shifted(field.leaves[i].origin, 3), static_cast<std::uint32_t>(i));
    occupy(field.leaves[i].origin, 8);
  }
  for (std::size_t i = 0; i < field.tiles.size(); ++i) {
    const Tile& tile = field.tiles[i];
    assert(tile.width >= 8 && std::has_single_bit(static_cast<unsigned>(tile.width)));
    const int bits = log2_of(tile.width);
    auto tile_class = std::find_if(tiles_.begin(), tiles_.end(),
                                   [bits](const TileClass& c) { return c.log2_width == bits; });
    if (tile_class == tiles_.end()) tile_class = tiles_.insert(tiles_.end(), {bits, {}});
    tile_class->tiles.insert(shifted(tile.origin, bits), static_cast<std::uint32_t>(i));
    occupy(tile.origin, tile.width);
  }
}

CellBlock FieldLookup::cell_block(const glm::ivec3& key) const {
  CellBlock block;
  block.key = key;
  block.channels = field_->channels;
  bool stored = false;
  for (int i = 0; i < 8; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const glm::ivec3 voxels = key + neighbour(i);
    block.values[n] = {zeros.data(), of_one_value};
    if (const std::uint32_t leaf = leaves_.find(voxels); leaf != BlockMap::none) {
      block.values[n] = values_of(*field_, field_->leaves[leaf]);
      stored = true;
      continue;
    }
    for (const TileClass& c : tiles_) {
      const std::uint32_t tile = c.tiles.find(shifted(voxels, c.log2_width - 3));
      if (tile == BlockMap::none) continue;
      block.values[n] = {glm::value_ptr(field_->tiles[tile].value), of_one_value};
      stored = true;
    }
  }
  block.empty = !stored || all_zero(block);
  return block;
}

bool FieldLookup::may_hold_values(int level, const glm::ivec3& key) const {
  const auto l = static_cast<std::size_t>(level);
  if (l >= occupied_.size() || occupied_[l].find(key) != BlockMap::none) return true;
  const int bits = log2_of(widths[l]);
  for (const TileClass& c : tiles_) {
    if (c.log2_width < bits) continue;
    for (int i = 0; i < 8; ++i)
      if (c.tiles.find(shifted(key + neighbour(i), c.log2_width - bits)) != BlockMap::none)
        return true;
  }
  return false;
}

double FieldLookup::max_magnitude() const {
  double largest = 0;
  for (const Leaf& leaf : field_->leaves)
    for (const float value : OrderedValues(*field_, leaf))
      largest = std::max(largest, std::abs(static_cast<double>(value)));
  for (const Tile& tile : field_->tiles)
    for (int c = 0; c < field_->channels; ++c)
      largest = std::max(largest, std::abs(static_cast<double>(tile.value[c])));
  return largest;
}

// 8 x 8 x 16 neighbouring blocks have distinct slots, which the rays of one image tile share.
BlockCache::BlockCache(const FieldLookup& lookup) : lookup_(&lookup), blocks_(1024) {
  for (CellBlock& block : blocks_) block.key = glm::ivec3(INT_MIN);  // no block has this key
}

const CellBlock& BlockCache::at(const glm::ivec3& key) {
  const int slot = (key.x & 7) | (key.y & 7) << 3 | (key.z & 15) << 6;
  CellBlock& block = blocks_[static_cast<std::size_t>(slot)];
  if (block.key != key) block = lookup_->cell_block(key);
  return block;
}

}  // namespace psivox
