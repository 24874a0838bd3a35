#include "topology.h"

#include <algorithm>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <type_traits>

#include "grid_types.h"
#include "leaf_decoder.h"
#include "leaf_floats.h"

namespace psivox::vdb {
namespace {

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

  TopologyReader(GridT& grid, std::istream& stream)
      : stream_(stream), coding_{openvdb::io::getDataCompression(stream), grid.saveFloatAsHalf()} {
    constexpr int none = std::numeric_limits<int>::max();
    box_ = {glm::ivec3(none), glm::ivec3(-none)};
    read_root(grid.tree().root());
  }

  Topology take() {
    std::stable_sort(
        found_.tiles.begin(), found_.tiles.end(),
        [](const TilePart& a, const TilePart& b) { return a.tile.width > b.tile.width; });
    GridSummary& summary = found_.summary;
    summary.channels = is_vec<ValueT> ? 3 : 1;
    summary.leaves = found_.leaves.size();
    if (summary.active_voxels > 0) summary.active_box = box_;
    if constexpr (is_vec<ValueT>)
      summary.background = {double(background_[0]), double(background_[1]), double(background_[2])};
    else
      summary.background = openvdb::Vec3d(static_cast<double>(background_));
    return std::move(found_);
  }

 private:
  template <typename T>
  T read() {
    T value;
    stream_.read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }

  openvdb::Coord read_origin() {
    openvdb::Int32 at[3];
    stream_.read(reinterpret_cast<char*>(at), sizeof at);
    const openvdb::Coord origin(at);
    if ((origin & ~(int(Root::ChildNodeType::DIM) - 1)) != origin)
      throw openvdb::IoError("a node of its root is at an impossible place");
    return origin;
  }

  void read_root(Root& root) {
    read<std::uint32_t>();  // number of buffers
    background_ = read<ValueT>();
    root.setBackground(background_, /*updateChildNodes=*/false);
    openvdb::io::setGridBackgroundValuePtr(stream_, &background_);
    auto tiles = read<std::uint32_t>(), children = read<std::uint32_t>();
    for (; tiles > 0; --tiles) {
      const openvdb::Coord origin = read_origin();
      const auto value = read<ValueT>();
      add_tile(origin, int(Root::ChildNodeType::DIM), value, read<char>() != 0);
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
    if (mask.isOff()) return;
    found_.summary.active_voxels += mask.countOn();
    const Box box = active_box_of(mask);
    box_ = {glm::min(box_.min, at + box.min), glm::max(box_.max, at + box.max)};
  }

  void add_tile(const openvdb::Coord& origin, int width, const ValueT& value, bool active) {
    if (!active && !(value != background_)) return;
    const Tile tile{to_ivec3(origin), width, to_vec3(value)};
    found_.tiles.push_back({tile, active});
    if (!active) return;
    ++found_.summary.active_tiles;
    found_.summary.active_voxels +=
        std::uint64_t(width) * std::uint64_t(width) * std::uint64_t(width);
    box_ = {glm::min(box_.min, tile.origin), glm::max(box_.max, tile.origin + (width - 1))};
  }

  std::istream& stream_;
  ValueCoding coding_;
  ValueT background_{};
  Box box_;
  Topology found_;
};

}  // namespace

Topology read_topology(openvdb::GridBase& empty, std::istream& stream) {
  Topology topology;
  empty.apply<SupportedGrids>([&](auto& typed) {
    topology = TopologyReader<std::decay_t<decltype(typed)>>(typed, stream).take();
  });
  return topology;
}

}  // namespace psivox::vdb
