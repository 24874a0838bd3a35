#include "topology.h"

#include <array>
#include <memory>
#include <optional>
#include <set>

#include "values.h"

namespace psivox::vdb {
namespace {

constexpr int root_child_width = 4096;

template <typename ValueT>
class TopologyReader {
 public:
  TopologyReader(GridHead& head, std::istream& stream, const ValueCoding& coding,
                 const TopologyWish& wish)
      : stream_(stream), coding_(coding), found_(wish) {
    read_root();
    head.set_background(background_);
  }

  Topology take() { return found_.take(); }

 private:
  glm::ivec3 read_origin() {
    const auto origin = vdb::take<glm::ivec3>(stream_);
    const bool within = (origin & ~(root_child_width - 1)) == origin;
    if (!within || !roots_.insert({origin.x, origin.y, origin.z}).second)
      throw std::runtime_error("a node of its root is at an impossible place");
    return origin;
  }

  void read_root() {
    vdb::take<std::uint32_t>(stream_);  // number of buffers
    background_ = vdb::take<ValueT>(stream_);
    found_.set_background(background_);
    auto tiles = vdb::take<std::uint32_t>(stream_), children = vdb::take<std::uint32_t>(stream_);
    for (; tiles > 0; --tiles) {
      const glm::ivec3 origin = read_origin();
      const auto value = vdb::take<ValueT>(stream_);
      found_.add_tile(origin, root_child_width, value, vdb::take<char>(stream_) != 0);
    }
    std::optional<glm::ivec3> last;
    for (; children > 0; --children) {
      const glm::ivec3 origin = read_origin();
      // the values of leaves come in that order
      if (last && !comes_before(*last, origin))
        throw std::runtime_error("the nodes of its root are out of order");
      last = origin;
      read_inner<5>(origin);
    }
  }

  /// A node of 2^side tiles or children in each direction.
  template <unsigned side>
  void read_inner(const glm::ivec3& origin) {
    using Mask = openvdb::util::NodeMask<side>;
    Mask children, active;
    children.load(stream_);
    active.load(stream_);
    const auto values = std::make_unique_for_overwrite<ValueT[]>(Mask::SIZE);
    read_values(stream_, active, background_, coding_, values.get());
    found_.template add_inner<side>(
        origin, children, active, [&](unsigned n) { return values[n]; },
        [&](unsigned, const glm::ivec3& place) {
          if constexpr (side == 4)
            read_leaf(place);
          else
            read_inner<4>(place);
        });
  }

  void read_leaf(const glm::ivec3& origin) {
    LeafMask mask;
    mask.load(stream_);
    found_.add_leaf(origin, mask);
  }

  std::istream& stream_;
  ValueCoding coding_;
  std::set<std::array<int, 3>> roots_;  ///< origins of tiles and nodes of the root
  ValueT background_{};
  TopologyBuilder<ValueT> found_;
};

}  // namespace

Topology read_topology(GridHead& head, std::istream& stream, const ValueCoding& coding,
                       const TopologyWish& wish) {
  return with_value_type(head.type, [&]<typename ValueT>() {
    return TopologyReader<ValueT>(head, stream, coding, wish).take();
  });
}

}  // namespace psivox::vdb
