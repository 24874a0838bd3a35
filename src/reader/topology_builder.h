#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "field/value_range.h"
#include "grid_values.h"
#include "vdb/topology.h"

namespace psivox::vdb {

inline glm::ivec3 place_of(const openvdb::Coord& at) { return {at.x(), at.y(), at.z()}; }

/// A leaf's mask of OpenVDB or NanoVDB.
template <typename MaskT>
LeafMask mask_of(const MaskT& mask) {
  LeafMask words;
  static_assert(sizeof mask == sizeof words);
  std::memcpy(static_cast<void*>(&words), &mask, sizeof words);
  return words;
}

/// The smallest box around a leaf's active voxels, of which there are some.
inline Box active_box_of(const LeafMask& mask) {
  Box box{glm::ivec3(7), glm::ivec3(0)};
  std::uint64_t layers = 0;
  for (int x = 0; x < 8; ++x) {
    const std::uint64_t word = mask.words[std::size_t(x)];
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

/// Gathers a grid's topology from its nodes, which come in the tree's order.
template <typename ValueT>
class TopologyBuilder {
 public:
  /// `fill`: the value that inactive tiles of the background get; unset: they are left out.
  TopologyBuilder(const std::optional<double>& fill, const ValueT& background)
      : fill_(fill), background_(background) {
    constexpr int none = std::numeric_limits<int>::max();
    box_ = {glm::ivec3(none), glm::ivec3(-none)};
  }

  void add_leaf(const glm::ivec3& at, const LeafMask& mask) {
    found_.leaves.push_back(at);
    found_.masks.push_back(mask);
    if (mask.none()) return;
    found_.summary.active_voxels += std::uint64_t(mask.count());
    const Box box = active_box_of(mask);
    box_ = {glm::min(box_.min, at + box.min), glm::max(box_.max, at + box.max)};
  }

  void add_tile(const glm::ivec3& origin, int width, const ValueT& value, bool active) {
    if (!active && same_values(value, background_)) {
      if (fill_) found_.tiles.push_back({origin, width, glm::dvec3(*fill_), false});
      return;
    }
    const TilePart tile{origin, width, to_dvec3(value), active};
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
    summary.channels = channels_of_value<ValueT>;
    summary.leaves = found_.leaves.size();
    if (summary.active_voxels > 0) summary.active_box = box_;
    summary.background =
        summary.channels == 3 ? to_dvec3(background_) : glm::dvec3(to_dvec3(background_).x);
    return std::move(found_);
  }

 private:
  std::optional<double> fill_;
  ValueT background_;
  Box box_;
  Topology found_;
};

/// Calls visit(leaf) for each leaf of an OpenVDB tree, in its order, and tells `found` of all
/// tiles.
template <typename NodeT, typename ValueT, typename Visit>
void take_nodes(NodeT& node, TopologyBuilder<ValueT>& found, const Visit& visit) {
  if constexpr (NodeT::LEVEL == 0) {
    found.add_leaf(place_of(node.origin()), mask_of(node.getValueMask()));
    visit(node);
  } else {
    constexpr int width = NodeT::ChildNodeType::DIM;
    for (auto tile = node.cbeginValueAll(); tile; ++tile)
      found.add_tile(place_of(tile.getCoord()), width, *tile, tile.isValueOn());
    for (auto child = node.beginChildOn(); child; ++child) take_nodes(*child, found, visit);
  }
}

}  // namespace psivox::vdb
