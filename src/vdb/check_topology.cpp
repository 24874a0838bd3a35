#include "check_topology.h"

#include <cstdint>
#include <type_traits>

#include "grid_types.h"
#include "value_block.h"

namespace psivox::vdb {
namespace {

template <typename NodeT>
void skip_inner_node(std::istream& stream, const ValueCoding& coding) {
  using Child = typename NodeT::ChildNodeType;
  typename NodeT::NodeMaskType children, active;
  children.load(stream);
  active.load(stream);
  skip_values<typename NodeT::ValueType>(stream, active, coding);
  if constexpr (Child::LEVEL == 0) {
    const typename Child::NodeMaskType leaf;
    stream.seekg(std::int64_t{children.countOn()} * leaf.memUsage(), std::ios_base::cur);
  } else {
    for (auto n = children.countOn(); n > 0; --n) skip_inner_node<Child>(stream, coding);
  }
}

template <typename TreeT>
void skip_tree(std::istream& stream, const ValueCoding& coding) {
  constexpr std::int64_t value = sizeof(typename TreeT::ValueType), origin = 3 * 4;
  std::uint32_t buffers, tiles, children;
  stream.read(reinterpret_cast<char*>(&buffers), sizeof buffers);
  stream.seekg(value, std::ios_base::cur);  // the background
  stream.read(reinterpret_cast<char*>(&tiles), sizeof tiles);
  stream.read(reinterpret_cast<char*>(&children), sizeof children);
  stream.seekg(tiles * (origin + value + 1), std::ios_base::cur);  // 1: whether it is active
  for (; children > 0; --children) {
    stream.seekg(origin, std::ios_base::cur);
    skip_inner_node<typename TreeT::RootNodeType::ChildNodeType>(stream, coding);
  }
}

}  // namespace

void check_topology(openvdb::GridBase& grid, std::istream& stream) {
  const ValueCoding coding{openvdb::io::getDataCompression(stream), grid.saveFloatAsHalf()};
  if (!coding.has_lengths()) return;
  const auto begin = stream.tellg();
  grid.apply<SupportedGrids>([&](auto& typed) {
    skip_tree<typename std::decay_t<decltype(typed)>::TreeType>(stream, coding);
  });
  stream.seekg(begin);
}

void check_root(const openvdb::GridBase& grid) {
  with_typed_grid(grid, [](const auto& typed) {
    const auto& root = typed.tree().root();
    constexpr int width = std::decay_t<decltype(root)>::ChildNodeType::DIM;
    for (auto it = root.cbeginChildAll(); it; ++it)
      if ((it.getCoord() & ~(width - 1)) != it.getCoord())
        throw openvdb::IoError("a node of its root is at an impossible place");
  });
}

}  // namespace psivox::vdb
