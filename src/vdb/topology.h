#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <istream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "field/value_range.h"
#include "grid_head.h"
#include "psivox/field.h"
#include "survey.h"
#include "values.h"

// What is read of a grid: its topology, and then its leaves.

namespace psivox::vdb {

/// Facts about a tree for the checks and the info rows.
struct GridSummary {
  int channels = 0;
  std::uint64_t active_voxels = 0;  ///< active tiles count with all their voxels
  std::uint64_t leaves = 0;
  std::uint64_t active_tiles = 0;
  Box active_box;
  glm::dvec3 background{0};  ///< a scalar's in every component
};

/// A value in a tree's node that fills a cube of voxels. As double it keeps the grid's own type.
struct TilePart {
  glm::ivec3 origin;
  int width;
  glm::dvec3 value;
  bool active;

  Tile tile() const { return {origin, width, glm::vec3(value)}; }
};

/// A grid's tree without values of leaves.
struct Topology {
  std::vector<glm::ivec3> leaves;     ///< their origins, in the tree's order
  std::vector<std::uint16_t> active;  ///< voxels of each leaf
  std::vector<LeafMask> masks;        ///< of each leaf, if wanted
  /// Tiles of the root first, then those 128 voxels wide, then those 8 voxels wide, without
  /// inactive tiles of the background's value.
  std::vector<TilePart> tiles;
  GridSummary summary;
};

struct TopologyWish {
  bool masks = false;
  std::optional<glm::dvec3> background = {};  ///< inactive tiles of the background have this value
};

/// Reads the topology of a grid from the stream, which is at its tree, in a few bytes a leaf: no
/// node is made. The file's format must be 222 or later. The head gets the tree's background.
/// Throws if the file is damaged.
Topology read_topology(GridHead& head, std::istream& stream, const ValueCoding& coding,
                       const TopologyWish& wish = {});

/// Whether a voxel comes before another in OpenVDB's order.
inline bool comes_before(const glm::ivec3& a, const glm::ivec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// The smallest box around a leaf's active voxels, of which there are some.
inline Box active_box_of(const LeafMask& mask) {
  // a word is a layer of x, its bits are 8 y + z
  Box box{glm::ivec3(7), glm::ivec3(0)};
  std::uint64_t layers = 0;
  for (int x = 0; x < 8; ++x) {
    const auto word = mask.getWord<std::uint64_t>(static_cast<unsigned>(x));
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

/// Children of an inner node of 2^side in each direction are 2^this voxels wide.
template <unsigned side>
constexpr int child_bits = side == 5 ? 7 : 3;

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

  void add_leaf(const glm::ivec3& at, const LeafMask& mask) {
    found_.leaves.push_back(at);
    found_.active.push_back(static_cast<std::uint16_t>(mask.countOn()));
    if (wish_.masks) found_.masks.push_back(mask);
    if (mask.isOff()) return;
    found_.summary.active_voxels += mask.countOn();
    const Box box = active_box_of(mask);
    box_ = {glm::min(box_.min, at + box.min), glm::max(box_.max, at + box.max)};
  }

  void add_tile(const glm::ivec3& origin, int width, const ValueT& value, bool active) {
    if (!active && same_values(value, background_)) {
      if (wish_.background) found_.tiles.push_back({origin, width, *wish_.background, false});
      return;
    }
    const TilePart tile{origin, width, to_dvec3(value), active};
    found_.tiles.push_back(tile);
    if (!active) return;
    ++found_.summary.active_tiles;
    found_.summary.active_voxels += tile_voxels(tile.tile());
    box_ = {glm::min(box_.min, tile.origin), glm::max(box_.max, tile.origin + (width - 1))};
  }

  /// Takes an inner node, of 2^side tiles or children in each direction: its tiles, whose values
  /// value_of(n) are, and then its children, by take_child(n, origin).
  template <unsigned side, typename ValueOf, typename TakeChild>
  void add_inner(const glm::ivec3& origin, const openvdb::util::NodeMask<side>& children,
                 const openvdb::util::NodeMask<side>& active, const ValueOf& value_of,
                 const TakeChild& take_child) {
    const auto place = [&](unsigned n) {
      constexpr unsigned low = (1 << side) - 1;
      return origin +
             (glm::ivec3(n >> 2 * side, n >> side & low, n & low) << glm::ivec3(child_bits<side>));
    };
    for (auto n = children.beginOff(); n; ++n)
      add_tile(place(n.pos()), 1 << child_bits<side>, value_of(n.pos()), active.isOn(n.pos()));
    for (auto n = children.beginOn(); n; ++n) take_child(n.pos(), place(n.pos()));
  }

  Topology take() {
    std::stable_sort(found_.tiles.begin(), found_.tiles.end(),
                     [](const TilePart& a, const TilePart& b) { return a.width > b.width; });
    GridSummary& summary = found_.summary;
    summary.channels = ValueTraits<ValueT>::channels;
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

/// A leaf of a grid of any type.
class DecodedLeaf {
 public:
  explicit DecodedLeaf(const LeafMask& mask) : mask_(mask) {}

  const LeafMask& active() const { return mask_; }
  /// Copies 512 * channels values, vectors interleaved.
  virtual void copy_to(float* values) const = 0;
  virtual void copy_to(double* values) const = 0;

 protected:
  ~DecodedLeaf() = default;

 private:
  const LeafMask& mask_;
};

/// What becomes of a leaf, by its number. Several threads call it.
using TakeLeaf = std::function<void(std::size_t n, const DecodedLeaf& leaf)>;

/// A leaf whose values copy(values) writes, to floats or to doubles.
template <typename Copy>
class MadeLeaf final : public DecodedLeaf {
 public:
  MadeLeaf(const LeafMask& mask, const Copy& copy) : DecodedLeaf(mask), copy_(copy) {}
  void copy_to(float* values) const override { copy_(values); }
  void copy_to(double* values) const override { copy_(values); }

 private:
  Copy copy_;
};

/// Such a function, by the value of each voxel.
template <typename ValueOf>
auto each_voxel(const ValueOf& value_of) {
  return [value_of](auto* values) {
    for (std::size_t i = 0; i < kLeafVoxels; ++i)
      values[i] = static_cast<std::decay_t<decltype(*values)>>(value_of(i));
  };
}

/// How many points each voxel of a leaf has.
using PointCounts = std::array<std::int32_t, kLeafVoxels>;

/// The same from the offsets behind each voxel's last point. Throws std::runtime_error.
template <typename EndOf>
PointCounts point_counts(const EndOf& end_of) {
  PointCounts counts;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const std::uint32_t end = end_of(i), count = end - last;
    if (end < last || count > std::uint32_t(std::numeric_limits<std::int32_t>::max()))
      throw std::runtime_error("its points are out of order");
    counts[i] = std::int32_t(count);
    last = end;
  }
  return counts;
}

}  // namespace psivox::vdb
