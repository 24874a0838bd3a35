#include "topology.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <set>
#include <type_traits>

#include "grid_types.h"
#include "psivox/value_percentile.h"
#include "value_block.h"

namespace psivox::vdb {
namespace {

glm::ivec3 to_ivec3(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

template <typename ValueT>
glm::dvec3 to_dvec3(const ValueT& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return {double(value[0]), double(value[1]), double(value[2])};
  else
    return {static_cast<double>(value), 0, 0};
}

/// The smallest box around a leaf's active voxels, of which there are some.
Box active_box_of(const LeafMask& mask) {
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

template <typename GridT>
class TopologyReader {
 public:
  using ValueT = typename GridT::ValueType;
  using Root = typename GridT::TreeType::RootNodeType;

  TopologyReader(GridT& grid, std::istream& stream, const TopologyWish& wish)
      : stream_(stream), coding_(stream), wish_(wish) {
    constexpr int none = std::numeric_limits<int>::max();
    box_ = {glm::ivec3(none), glm::ivec3(-none)};
    read_root(grid.tree().root());
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
  openvdb::Coord read_origin() {
    const auto at = vdb::take<std::array<openvdb::Int32, 3>>(stream_);
    const openvdb::Coord origin(at.data());
    if ((origin & ~(int(Root::ChildNodeType::DIM) - 1)) != origin || !roots_.insert(origin).second)
      throw openvdb::IoError("a node of its root is at an impossible place");
    return origin;
  }

  void read_root(Root& root) {
    vdb::take<std::uint32_t>(stream_);  // number of buffers
    background_ = vdb::take<ValueT>(stream_);
    root.setBackground(background_, /*updateChildNodes=*/false);
    openvdb::io::setGridBackgroundValuePtr(stream_, &background_);
    auto tiles = vdb::take<std::uint32_t>(stream_), children = vdb::take<std::uint32_t>(stream_);
    for (; tiles > 0; --tiles) {
      const openvdb::Coord origin = read_origin();
      const auto value = vdb::take<ValueT>(stream_);
      add_tile(origin, int(Root::ChildNodeType::DIM), value, vdb::take<char>(stream_) != 0);
    }
    openvdb::Coord last = openvdb::Coord::min();
    for (; children > 0; --children) {
      const openvdb::Coord origin = read_origin();
      // the values of leaves come in that order
      if (!(last < origin)) throw openvdb::IoError("the nodes of its root are out of order");
      last = origin;
      read_inner<typename Root::ChildNodeType>(origin);
    }
    openvdb::io::setGridBackgroundValuePtr(stream_, nullptr);
  }

  template <typename NodeT>
  void read_inner(const openvdb::Coord& origin) {
    using Child = typename NodeT::ChildNodeType;
    typename NodeT::NodeMaskType children, active;
    children.load(stream_);
    active.load(stream_);
    const auto values_at = stream_.tellg();
    skip_values<ValueT>(stream_, active, coding_);  // checks their length
    stream_.seekg(values_at);
    const std::unique_ptr<ValueT[]> values(new ValueT[NodeT::NUM_VALUES]);
    openvdb::io::readCompressedValues(stream_, values.get(), NodeT::NUM_VALUES, active,
                                      coding_.half);
    const auto place = [&](openvdb::Index n) {
      openvdb::Coord at;
      NodeT::offsetToLocalCoord(n, at);
      return origin + (at << Child::TOTAL);
    };
    for (auto n = children.beginOff(); n; ++n)
      add_tile(place(n.pos()), int(Child::DIM), values[n.pos()], active.isOn(n.pos()));
    for (auto n = children.beginOn(); n; ++n) {
      if constexpr (Child::LEVEL == 0)
        read_leaf(place(n.pos()));
      else
        read_inner<Child>(place(n.pos()));
    }
  }

  void read_leaf(const openvdb::Coord& origin) {
    LeafMask mask;
    mask.load(stream_);
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

  std::istream& stream_;
  ValueCoding coding_;
  TopologyWish wish_;
  std::set<openvdb::Coord> roots_;  ///< origins of tiles and nodes of the root
  ValueT background_{};
  Box box_;
  Topology found_;
};

}  // namespace

Topology read_topology(openvdb::GridBase& empty, std::istream& stream, const TopologyWish& wish) {
  Topology topology;
  empty.apply<SupportedGrids>([&](auto& typed) {
    topology = TopologyReader<std::decay_t<decltype(typed)>>(typed, stream, wish).take();
  });
  return topology;
}

}  // namespace psivox::vdb
