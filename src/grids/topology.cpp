#include "topology.h"

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <type_traits>

#include "grid_types.h"
#include "value_block.h"

namespace psivox::vdb {
namespace {

template <typename GridT>
class TopologyReader {
 public:
  using ValueT = typename GridT::ValueType;
  using Root = typename GridT::TreeType::RootNodeType;

  TopologyReader(GridT& grid, std::istream& stream, const TopologyWish& wish)
      : stream_(stream), coding_(stream), found_(wish) {
    read_root(grid.tree().root());
  }

  Topology take() { return found_.take(); }

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
    found_.set_background(background_);
    root.setBackground(background_, /*updateChildNodes=*/false);
    openvdb::io::setGridBackgroundValuePtr(stream_, &background_);
    auto tiles = vdb::take<std::uint32_t>(stream_), children = vdb::take<std::uint32_t>(stream_);
    for (; tiles > 0; --tiles) {
      const openvdb::Coord origin = read_origin();
      const auto value = vdb::take<ValueT>(stream_);
      found_.add_tile(origin, int(Root::ChildNodeType::DIM), value, vdb::take<char>(stream_) != 0);
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
    typename NodeT::NodeMaskType children, active;
    children.load(stream_);
    active.load(stream_);
    const auto values_at = stream_.tellg();
    skip_values<ValueT>(stream_, active, coding_);  // checks their length
    stream_.seekg(values_at);
    const std::unique_ptr<ValueT[]> values(new ValueT[NodeT::NUM_VALUES]);
    openvdb::io::readCompressedValues(stream_, values.get(), NodeT::NUM_VALUES, active,
                                      coding_.half);
    found_.add_inner(
        origin, children, active, [&](openvdb::Index n) { return values[n]; },
        [&](openvdb::Index, const openvdb::Coord& place) {
          if constexpr (NodeT::LEVEL == 1)
            read_leaf(place);
          else
            read_inner<typename NodeT::ChildNodeType>(place);
        });
  }

  void read_leaf(const openvdb::Coord& origin) {
    LeafMask mask;
    mask.load(stream_);
    found_.add_leaf(origin, mask);
  }

  std::istream& stream_;
  ValueCoding coding_;
  std::set<openvdb::Coord> roots_;  ///< origins of tiles and nodes of the root
  ValueT background_{};
  TopologyBuilder<ValueT> found_;
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
