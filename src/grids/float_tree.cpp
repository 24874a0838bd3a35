#include "read_grid.h"

#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tree/NodeManager.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "field/index_space.h"

namespace psivox::vdb {
namespace {

using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>;

/// Upper bound of the resampled box: 256 MiB of floats if every voxel is active.
constexpr double kMaxResampledVoxels = 67108864;  // 2^26

/// Calls op(node) for the root, each inner node and each leaf, from the root down, each level in
/// the tree's order.
template <typename TreeT, typename Op>
void each_node(TreeT& tree, bool in_threads, const Op& op) {
  openvdb::tree::NodeManager<TreeT>(tree).foreachTopDown(op, in_threads);
}

template <typename ValueT>
ValueT value_of(const glm::vec3& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return ValueT(value.x, value.y, value.z);
  else
    return value.x;
}

float* floats_of(float* values) { return values; }
float* floats_of(openvdb::Vec3f* values) { return values->asPointer(); }

template <typename GridT>
openvdb::GridBase::Ptr tree_of(FileGrid& from) {
  using ValueT = typename GridT::ValueType;
  using LeafT = typename GridT::TreeType::LeafNodeType;
  const auto grid = new_grid<GridT>();
  auto& root = grid->tree().root();
  const Topology& topology = from.topology();
  root.setBackground(value_of<ValueT>(glm::vec3(topology.summary.background)),
                     /*updateChildNodes=*/false);
  const auto coord = [](const glm::ivec3& at) { return openvdb::Coord(at.x, at.y, at.z); };
  for (const TilePart& tile : topology.tiles) {
    const openvdb::Index level = tile.width == LeafT::DIM ? 1 : tile.width == 128 ? 2 : 3;
    root.addTile(level, coord(tile.origin), value_of<ValueT>(glm::vec3(tile.value)), tile.active);
  }
  std::vector<LeafT*> leaves;
  leaves.reserve(topology.leaves.size());
  for (const glm::ivec3& origin : topology.leaves) {
    leaves.push_back(new LeafT(coord(origin)));
    root.addLeaf(leaves.back());
  }
  from.each_leaf([&](std::size_t n, const DecodedLeaf& leaf) {
    leaf.copy_to(floats_of(leaves[n]->buffer().data()));
    leaves[n]->setValueMask(leaf.active());
  });
  return grid;
}

template <typename GridT>
Voxels take_voxels(GridT& grid, Topology& topology) {
  TopologyBuilder<typename GridT::ValueType> found({});
  found.set_background(grid.background());
  Voxels voxels;
  each_node(grid.tree(), false, [&]<typename NodeT>(NodeT& node) {
    if constexpr (NodeT::LEVEL == 0) {
      found.add_leaf(node.origin(), node.getValueMask());
      voxels.leaves.push_back(floats_of(node.buffer().data()));
      voxels.active.push_back(node.getValueMask());
    } else {
      for (auto it = node.cbeginValueAll(); it; ++it)
        found.add_tile(it.getCoord(), int(NodeT::ChildNodeType::DIM), *it, it.isValueOn());
    }
  });
  topology = found.take();
  voxels.tiles = topology.tiles;
  return voxels;
}

/// Least and greatest of 0 and the finite active values.
glm::vec2 active_bounds(const openvdb::FloatGrid& grid) {
  glm::vec2 bounds(0);
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    const float value = *it;
    if (!std::isfinite(value)) continue;
    bounds = {std::min(bounds.x, value), std::max(bounds.y, value)};
  }
  return bounds;
}

struct Lattice {
  openvdb::Vec3d origin;  ///< world position of index (0,0,0)
  double voxel_size;
  bool coarsened;  ///< to respect kMaxResampledVoxels
};

/// The lattice of cubic voxels over the world box of the active voxels.
Lattice lattice_of(const openvdb::GridBase& grid) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  const openvdb::math::Transform& transform = grid.transform();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  openvdb::Vec3d lo(infinity), hi(-infinity);
  double voxel_size = infinity;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 at = corner_of({to_ivec3(box.min()), to_ivec3(box.max())}, corner);
    const openvdb::Vec3d index(at.x, at.y, at.z);
    const openvdb::Vec3d world = transform.indexToWorld(index);
    lo = openvdb::math::minComponent(lo, world);
    hi = openvdb::math::maxComponent(hi, world);
    const openvdb::Vec3d size = transform.voxelSize(index);
    voxel_size = std::min({voxel_size, size[0], size[1], size[2]});
  }
  const openvdb::Vec3d extent = hi - lo;
  if (!(voxel_size > 0.0) || !std::isfinite(extent.length())) {
    throw std::runtime_error("has a frustum transform that is singular within its active voxels");
  }
  Lattice lattice{lo, voxel_size, false};
  const auto voxels = [&] {
    double product = 1.0;
    for (int axis = 0; axis < 3; ++axis) product *= extent[axis] / lattice.voxel_size + 1.0;
    return product;
  };
  while (voxels() > kMaxResampledVoxels) {
    lattice.voxel_size *= std::max(std::cbrt(voxels() / kMaxResampledVoxels), 1.01);
    lattice.coarsened = true;
  }
  return lattice;
}

}  // namespace

openvdb::GridBase::Ptr float_tree(FileGrid& grid) {
  const auto tree =
      grid.channels() == 3 ? tree_of<openvdb::Vec3SGrid>(grid) : tree_of<openvdb::FloatGrid>(grid);
  tree->insertMeta(grid.head());
  tree->setTransform(grid.head().transform().copy());
  return tree;
}

Voxels voxels_of(const openvdb::GridBase::Ptr& grid, Topology& topology) {
  Voxels voxels;
  grid->apply<FloatGrids>([&](auto& typed) { voxels = take_voxels(typed, topology); });
  voxels.storage = grid;
  return voxels;
}

void complete_level_set(openvdb::FloatGrid& grid) {
  const glm::vec2 bounds = active_bounds(grid);
  if (!(bounds.x < 0 && bounds.y > 0)) return;
  const float outside = bounds.y;
  each_node(grid.tree(), true, [&](auto& node) {
    for (auto off = node.beginValueOff(); off; ++off)
      if (off.getValue() == 0) off.setValue(outside);
  });
  grid.tree().root().setBackground(outside, /*updateChildNodes=*/false);
}

void make_fog(openvdb::FloatGrid& grid) { openvdb::tools::sdfToFogVolume(grid); }

void make_distances(openvdb::FloatGrid& grid) {
  openvdb::FloatTree& tree = grid.tree();
  const float half_width = tree.background();
  // Inactive tiles lie both inside and outside.
  each_node(tree, true, [&](auto& node) {
    for (auto it = node.beginValueAll(); it; ++it) {
      it.setValue(half_width - *it);
      it.setValueOn(*it != 0.0f);
    }
  });
  // Changes the root only; elsewhere the background is in tiles and voxels, which are converted.
  tree.root().setBackground(0.0f, /*updateChildNodes=*/false);
  grid.setGridClass(openvdb::GRID_UNKNOWN);
}

openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice) {
  const Lattice lattice = lattice_of(*grid);
  const auto transform = openvdb::math::Transform::createLinearTransform(lattice.voxel_size);
  transform->postTranslate(lattice.origin);

  openvdb::GridBase::Ptr result = grid->copyGridWithNewTree();
  result->setTransform(transform);
  // Whatever the class says, the values are not distances (any more), so no level set is rebuilt.
  grid->setGridClass(openvdb::GRID_UNKNOWN);
  const auto resample = [&](const auto& from) {
    using GridT = std::decay_t<decltype(from)>;
    openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(
        from, *openvdb::gridPtrCast<GridT>(result));
  };
  grid->apply<FloatGrids>(resample);

  notice = formatted("frustum transform resampled to cubic voxels of size %g", lattice.voxel_size) +
           (lattice.coarsened ? " (larger than its smallest, to save memory)" : "");
  return result;
}

}  // namespace psivox::vdb
