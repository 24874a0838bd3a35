#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <utility>

#include "field/value_percentile.h"
#include "grid_types.h"
#include "topology.h"
#include "value_block.h"

namespace psivox::vdb {

inline glm::ivec3 to_ivec3(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

template <typename ValueT>
glm::dvec3 to_dvec3(const ValueT& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return {double(value[0]), double(value[1]), double(value[2])};
  else
    return {static_cast<double>(value), 0, 0};
}

/// The smallest box around a leaf's active voxels, of which there are some.
inline Box active_box_of(const LeafMask& mask) {
  // a word is a layer of x, its bits are 8 y + z
  Box box{glm::ivec3(7), glm::ivec3(0)};
  std::uint64_t layers = 0;
  for (int x = 0; x < 8; ++x) {
    const auto word = mask.getWord<openvdb::Index64>(static_cast<openvdb::Index>(x));
    if (word == 0) continue;
    box.min.x = std::min(box.min.x, x);
    box.max.x = x;
    layers |= word;
  }
  for (int bit = 0; bit < 64; ++bit) {
    if (!(layers >> bit & 1)) continue;
    box.min.y = std::min(box.min.y, bit >> 3);
    box.max.y = std::max(box.max.y, bit >> 3);
    box.min.z = std::min(box.min.z, bit & 7);
    box.max.z = std::max(box.max.z, bit & 7);
  }
  return box;
}

/// Gathers a grid's topology from its nodes, which come in the tree's order. `ValueT` is the
/// grid's.
template <typename ValueT>
class TopologyBuilder {
 public:
  explicit TopologyBuilder(const TopologyWish& wish) : wish_(wish) {
    constexpr int none = std::numeric_limits<int>::max();
    box_ = {glm::ivec3(none), glm::ivec3(-none)};
  }

  /// Comes before tiles.
  void set_background(const ValueT& background) { background_ = background; }

  void add_leaf(const openvdb::Coord& origin, const LeafMask& mask) {
    const glm::ivec3 at = to_ivec3(origin);
    found_.leaves.push_back(at);
    found_.active.push_back(static_cast<std::uint16_t>(mask.countOn()));
    if (wish_.masks) found_.masks.push_back(mask);
    if (mask.isOff()) return;
    found_.summary.active_voxels += mask.countOn();
    const Box box = active_box_of(mask);
    box_ = {glm::min(box_.min, at + box.min), glm::max(box_.max, at + box.max)};
  }

  void add_tile(const openvdb::Coord& origin, int width, const ValueT& value, bool active) {
    if (!active && same_values(value, background_)) {
      if (wish_.background)
        found_.tiles.push_back({to_ivec3(origin), width, *wish_.background, false});
      return;
    }
    const TilePart tile{to_ivec3(origin), width, to_dvec3(value), active};
    found_.tiles.push_back(tile);
    if (!active) return;
    ++found_.summary.active_tiles;
    found_.summary.active_voxels += tile_voxels(tile.tile());
    box_ = {glm::min(box_.min, tile.origin), glm::max(box_.max, tile.origin + (width - 1))};
  }

  Topology take() {
    std::stable_sort(found_.tiles.begin(), found_.tiles.end(),
                     [](const TilePart& a, const TilePart& b) { return a.width > b.width; });
    GridSummary& summary = found_.summary;
    summary.channels = openvdb::VecTraits<ValueT>::IsVec ? 3 : 1;
    summary.leaves = found_.leaves.size();
    if (summary.active_voxels > 0) summary.active_box = box_;
    summary.background =
        summary.channels == 3 ? to_dvec3(background_) : glm::dvec3(to_dvec3(background_).x);
    return std::move(found_);
  }

 private:
  TopologyWish wish_;
  ValueT background_{};
  Box box_;
  Topology found_;
};

}  // namespace psivox::vdb
