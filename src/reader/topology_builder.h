#pragma once

#include <openvdb/openvdb.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/common.hpp>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "field/value_range.h"
#include "vdb/topology.h"

namespace psivox::vdb {

// Values of any grid, of OpenVDB's types and of NanoVDB's, as floats and doubles.

template <typename ValueT>
constexpr int channels_of_value = requires(const ValueT& v) {
  v[0];
}
? 3 : 1;

/// A number of a value, as float or double; `channel` is 0, or up to 2 of a vector.
template <typename To, typename ValueT>
To component_of(const ValueT& value, int channel) {
  if constexpr (channels_of_value<ValueT> == 3)
    return static_cast<To>(value[channel]);
  else if constexpr (std::is_arithmetic_v<ValueT>)
    return static_cast<To>(value);
  else if constexpr (std::is_same_v<ValueT, openvdb::math::half>)
    return static_cast<To>(static_cast<float>(value));
  else
    return static_cast<To>(static_cast<openvdb::Index32>(value));  // points
}

template <typename ValueT>
glm::dvec3 to_dvec3(const ValueT& value) {
  glm::dvec3 all(0);
  for (int c = 0; c < channels_of_value<ValueT>; ++c) all[c] = component_of<double>(value, c);
  return all;
}

/// Whether values are equal; NaN is the same as NaN.
template <typename ValueT>
bool same_values(const ValueT& a, const ValueT& b) {
  return a == b || (!(a == a) && !(b == b));
}

/// What a value consists of.
template <typename ValueT>
auto number_of(const ValueT& value) {
  if constexpr (channels_of_value<ValueT> == 3)
    return value[0];
  else if constexpr (std::is_same_v<ValueT, openvdb::math::half>)
    return static_cast<float>(value);
  else if constexpr (std::is_arithmetic_v<ValueT>)
    return value;
  else
    return std::int32_t{};  // points
}

/// The value whose numbers are all this one.
template <typename ValueT>
ValueT value_from(double number) {
  return ValueT(static_cast<decltype(number_of(ValueT()))>(number));
}

/// Whether a value can consist of this number.
template <typename ValueT>
bool value_can_be(double number) {
  using Limits = std::numeric_limits<decltype(number_of(ValueT()))>;
  // 2^63 is no int64, but the nearest double of the greatest.
  const bool within = number >= double(Limits::lowest()) && number < double(Limits::max()) + 1;
  return within && (!Limits::is_integer || number == std::trunc(number));
}

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
  unsigned xs = 0, zs = 0;  // a bit for each x and z that has some
  std::uint64_t layers = 0;
  for (unsigned x = 0; x < 8; ++x) {
    layers |= mask.words[x];
    xs |= unsigned(mask.words[x] != 0) << x;
  }
  for (int y = 0; y < 8; ++y) zs |= unsigned(layers >> 8 * y & 255);
  return {{std::countr_zero(xs), std::countr_zero(layers) / 8, std::countr_zero(zs)},
          {31 - std::countl_zero(xs), 7 - std::countl_zero(layers) / 8, 31 - std::countl_zero(zs)}};
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
