// Fields that come from a guarded process: they are taken from shared memory, and checked.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "field/block_map.h"
#include "field/index_space.h"
#include "field/leaf_values.h"
#include "reading_messages.h"
#include "survey.h"

namespace psivox::vdb {
namespace {

std::size_t leaf_bytes(const Field& field) {
  return kLeafVoxels * static_cast<std::size_t>(field.channels) * sizeof(float);
}

/// Leaves of a block: whole pages, at least 4 MiB of scalars, and no more blocks than an answer can
/// have.
std::size_t leaves_per_block(const Field& field) {
  constexpr std::size_t step = 2048, most_blocks = guard::most_descriptors - 1;
  return (field.leaves.size() / (step * most_blocks) + 1) * step;
}

constexpr const char* bad_values = "values are not finite, or negative";

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

/// Blocks must lie at the places of blocks of their width, in the tree's order, and none in
/// another.
void check_places(const Field& field) {
  constexpr std::array<int, 3> widths{4096, 128, 8};
  std::array<BlockMap, 3> taken;
  const auto add = [&](std::size_t level, const glm::ivec3& origin,
                       std::optional<TreeOrder>& last) {
    const TreeOrder order = tree_order(origin);
    require((origin & (widths[level] - 1)) == glm::ivec3(0),
            "a block lies between the places of blocks");
    require(!last || *last < order, "blocks are not in order");
    last = order;
    for (std::size_t wider = 0; wider <= level; ++wider)
      require(taken[wider].find(origin & ~(widths[wider] - 1)) == BlockMap::none, "blocks overlap");
    taken[level].insert(origin, 0);
  };
  std::size_t tiles = 0;
  for (std::size_t level = 0; level < widths.size(); ++level) {
    std::optional<TreeOrder> last;
    for (const Tile& tile : field.tiles)
      if (tile.width == widths[level]) {
        add(level, tile.origin, last);
        ++tiles;
      }
  }
  require(tiles == field.tiles.size(), "a tile has an impossible width");
  std::optional<TreeOrder> last;
  for (const Leaf& leaf : field.leaves) add(2, leaf.origin, last);
}

void check_range(const std::optional<glm::vec2>& range) {
  require(!range || !(std::isnan(range->x) || std::isnan(range->y)), "an impossible range");
}

void check_values(const Field& field, GridRole role, bool stored) {
  for (const Tile& tile : field.tiles)
    require(all_good({&tile.value.x, static_cast<std::size_t>(field.channels)}, role, field.absent),
            bad_values);
  if (stored) return;
  const auto check = [&](bool& good, const Leaf&, const OrderedValues& values) {
    good = good && all_good({values.begin(), values.size()}, role, field.absent);
  };
  require(fold_leaves(field, true, check, std::logical_and<>()), bad_values);
}

}  // namespace

std::vector<guard::Descriptor> shared_values(Field&& field) {
  std::vector<guard::Descriptor> blocks;
  const std::size_t size = leaf_bytes(field), at_once = leaves_per_block(field);
  for (std::size_t n = 0; n < field.leaves.size();) {
    std::vector<std::string_view> runs;
    for (const std::size_t end = std::min(n + at_once, field.leaves.size()); n < end; ++n) {
      const std::string_view values(reinterpret_cast<const char*>(field.leaves[n].values), size);
      if (!runs.empty() && runs.back().data() + runs.back().size() == values.data())
        runs.back() = {runs.back().data(), runs.back().size() + size};
      else
        runs.push_back(values);
    }
    blocks.push_back(guard::shared_copy(runs));
    field.storage.drop_before(n);
  }
  return blocks;
}

void take_values(Field& field, const std::vector<guard::SealedMemory>& blocks) {
  const std::size_t size = leaf_bytes(field), at_once = leaves_per_block(field);
  const std::size_t count = field.leaves.size();
  require(blocks.size() == (count + at_once - 1) / at_once, "another number of blocks");
  std::size_t all = 0;
  for (const guard::SealedMemory& block : blocks) {
    require(block.size() == std::min(at_once, count - all / size) * size, "a block's size");
    all += block.size();
  }
  std::vector<std::shared_ptr<const void>> maps;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const std::shared_ptr<const char> values = blocks[n].map();
    for (std::size_t leaf = n * at_once; leaf < std::min((n + 1) * at_once, count); ++leaf)
      field.leaves[leaf].values =
          reinterpret_cast<const float*>(values.get() + (leaf - n * at_once) * size);
    maps.push_back(values);
  }
  field.storage = Storage(std::move(maps), at_once);
}

void check_field(const Field& field, const ReadOptions& options) {
  const bool stored = stays_in_file(field);
  require(!stored || options.memory > 0 || options.in_file, "no values");
  require(field.channels == 1 || field.channels == 3, "an impossible number of channels");
  require(!field.active_box.empty() && !too_large(field.active_box), "an impossible box");
  const glm::ivec3 size = field.domain().max - field.domain().min;
  require(
      (field.margin == 0 || field.margin == 1) && glm::all(glm::greaterThan(size, glm::ivec3(0))),
      "an impossible domain");
  require(has_volume(field.world_from_index), "an impossible transform");
  require(std::isfinite(field.half_width) && field.half_width >= 0, "an impossible half width");
  require(field.scale == ValueScale{}, "an impossible scale of values");
  require(std::isfinite(field.replaced.least), "an impossible least value");
  check_range(field.active_range);
  check_range(field.stored_range);
  for (const auto& [percent, value] : field.active_percentiles)
    require(std::isfinite(percent) && !std::isnan(value), "an impossible percentile");
  check_places(field);
  check_values(field, options.role, stored);
}

}  // namespace psivox::vdb
