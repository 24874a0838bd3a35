#include "file_grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "grid_types.h"

namespace psivox::vdb {
namespace {

/// Tiles of the root that may be added: 28 MB of them.
constexpr double most_root_tiles = 1 << 20;

/// Throws std::runtime_error if components of the grid's type do not have the value.
void check_component(const openvdb::GridBase& grid, double value) {
  with_typed_grid(grid, [&](const auto& typed) {
    using ValueT = typename std::decay_t<decltype(typed)>::ValueType;
    using Limits = std::numeric_limits<typename openvdb::VecTraits<ValueT>::ElementType>;
    // 2^63 is no int64, but the nearest double of the greatest.
    const bool within = value >= double(Limits::lowest()) && value < double(Limits::max()) + 1;
    if (within && (!Limits::is_integer || value == std::trunc(value))) return;
    throw std::runtime_error(
        formatted("has no value %g, which --background-value asks for", value));
  });
}

}  // namespace

void FileGrid::begin(openvdb::GridBase::Ptr head, bool masks) {
  head_ = std::move(head);
  masks_ = masks || marked_;
  topology_ = read_topology({.masks = masks_});
  if (marked_) mark();
}

void FileGrid::mark() {
  const auto marks = new_grid<openvdb::FloatGrid>();
  marks->insertMeta(*head_);
  marks->setTransform(head_->transformPtr());
  marks->setGridClass(openvdb::GRID_UNKNOWN);
  head_ = marks;
  std::erase_if(topology_.tiles, [](const TilePart& tile) { return !tile.active; });
  for (TilePart& tile : topology_.tiles) tile.value = {1, 0, 0};
  topology_.summary.channels = 1;
  topology_.summary.background = glm::dvec3(0);
}

void FileGrid::set_background(double value) {
  check_component(*head_, value);
  fill_ = value;
  if (value != 0) {  // tiles of 0 are left out
    guarded([&] { topology_ = read_topology({.masks = masks_, .background = glm::dvec3(value)}); });
    if (summary().active_voxels > 0) fill_root(value);
  }
  topology_.summary.background = glm::dvec3(0);
}

/// Adds tiles to the root where it has neither a tile nor a node.
void FileGrid::fill_root(double value) {
  constexpr int width = 4096;
  const auto node_of = [](const glm::ivec3& voxel) {
    return openvdb::Coord(voxel.x, voxel.y, voxel.z) & ~(width - 1);
  };
  // One voxel around the active ones belongs to the domain.
  const Box& box = summary().active_box;
  const openvdb::Coord first = node_of(box.min - 1);
  double count = 1;
  for (int axis = 0; axis < 3; ++axis)
    count *= (double(box.max[axis]) + 1 - first[axis]) / width + 1;
  if (count > most_root_tiles)
    throw std::runtime_error(
        "is too wide to be filled with --background-value; only 0 needs no memory");
  std::vector<TilePart>& tiles = topology_.tiles;
  // a node has leaves or tiles everywhere
  std::set<openvdb::Coord> taken;
  for (const glm::ivec3& leaf : topology_.leaves) taken.insert(node_of(leaf));
  for (const TilePart& tile : tiles) taken.insert(node_of(tile.origin));
  for (int x = first.x(); x <= box.max.x + 1; x += width)
    for (int y = first.y(); y <= box.max.y + 1; y += width)
      for (int z = first.z(); z <= box.max.z + 1; z += width)
        if (!taken.contains({x, y, z}))
          tiles.push_back({{x, y, z}, width, glm::dvec3(value), false});
  std::ranges::stable_sort(tiles, [&](const TilePart& a, const TilePart& b) {
    if (a.width != b.width) return a.width > b.width;
    return a.width == width && node_of(a.origin) < node_of(b.origin);
  });
}

void FileGrid::each_leaf(const TakeLeaf& take, const std::function<bool()>& enough) {
  guarded([&] {
    if (!marked_) return read_leaves(take, enough);
    const std::vector<LeafMask>& masks = topology_.masks;
    tbb::parallel_for(std::size_t{0}, masks.size(), [&](std::size_t n) {
      take(n, MadeLeaf(masks[n], each_voxel([&](std::size_t i) {
                         return masks[n].isOn(static_cast<openvdb::Index>(i));
                       })));
    });
  });
}

}  // namespace psivox::vdb
