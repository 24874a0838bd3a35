#include "read_grid.h"

#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace psivox::vdb {
namespace {

using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>;

/// Upper bound of the resampled box: 256 MiB of floats if every voxel is active.
constexpr double kMaxResampledVoxels = 67108864;  // 2^26

/// The nodes of a tree by level, each level in the tree's order.
template <typename TreeT>
struct TreeNodes {
  using Root = typename TreeT::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  using Leaf = typename TreeT::LeafNodeType;

  explicit TreeNodes(TreeT& tree) : root(tree.root()) {
    tree.getNodes(uppers);
    tree.getNodes(lowers);
    tree.getNodes(leaves);
  }

  /// Calls op(node, width) for the root and each inner node, from the root down. Their tiles are
  /// `width` voxels wide.
  template <typename Op>
  void for_each_with_tiles(Op&& op) const {
    op(root, static_cast<int>(Upper::DIM));
    for (Upper* node : uppers) op(*node, static_cast<int>(Lower::DIM));
    for (Lower* node : lowers) op(*node, static_cast<int>(Leaf::DIM));
  }

  Root& root;
  std::vector<Upper*> uppers;
  std::vector<Lower*> lowers;
  std::vector<Leaf*> leaves;
};

template <typename ValueT>
ValueT value_of(const glm::vec3& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return ValueT(value.x, value.y, value.z);
  else
    return value.x;
}

glm::vec3 to_vec3(float value) { return {value, 0, 0}; }
glm::vec3 to_vec3(const openvdb::Vec3f& value) { return {value[0], value[1], value[2]}; }

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
Voxels take_voxels(GridT& grid, GridSummary& summary, std::vector<glm::ivec3>& origins) {
  constexpr bool is_vec = openvdb::VecTraits<typename GridT::ValueType>::IsVec;
  const auto place = [](const openvdb::Coord& c) { return glm::ivec3(c.x(), c.y(), c.z()); };
  const auto& tree = grid.tree();
  const TreeNodes<typename GridT::TreeType> nodes(grid.tree());
  const auto background = grid.background();
  Voxels voxels;
  nodes.for_each_with_tiles([&](const auto& node, int width) {
    for (auto it = node.cbeginValueAll(); it; ++it)
      if (it.isValueOn() || it.getValue() != background)
        voxels.tiles.push_back(
            {place(it.getCoord()), width, glm::dvec3(to_vec3(it.getValue())), it.isValueOn()});
  });
  for (auto* leaf : nodes.leaves) {
    origins.push_back(place(leaf->origin()));
    voxels.leaves.push_back(floats_of(leaf->buffer().data()));
    voxels.active.push_back(leaf->getValueMask());
  }
  summary.channels = is_vec ? 3 : 1;
  summary.active_voxels = tree.activeVoxelCount();
  summary.background = glm::dvec3(to_vec3(background));
  openvdb::CoordBBox box;
  tree.root().evalActiveBoundingBox(box);
  if (!box.empty()) summary.active_box = {place(box.min()), place(box.max())};
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
    const openvdb::Vec3d index((corner & 1 ? box.max() : box.min()).x(),
                               (corner & 2 ? box.max() : box.min()).y(),
                               (corner & 4 ? box.max() : box.min()).z());
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

Voxels voxels_of(const openvdb::GridBase::Ptr& grid, GridSummary& summary,
                 std::vector<glm::ivec3>& origins) {
  Voxels voxels;
  grid->apply<FloatGrids>([&](auto& typed) { voxels = take_voxels(typed, summary, origins); });
  voxels.storage = grid;
  return voxels;
}

void complete_level_set(openvdb::FloatGrid& grid) {
  const glm::vec2 bounds = active_bounds(grid);
  if (!(bounds.x < 0 && bounds.y > 0)) return;
  const float outside = bounds.y;
  const TreeNodes<openvdb::FloatTree> nodes(grid.tree());
  const auto replace = [&](auto& node) {
    for (auto off = node.beginValueOff(); off; ++off)
      if (off.getValue() == 0) off.setValue(outside);
  };
  nodes.for_each_with_tiles([&](auto& node, int) { replace(node); });
  for (auto* leaf : nodes.leaves) replace(*leaf);
  nodes.root.setBackground(outside, /*updateChildNodes=*/false);
}

void make_fog(openvdb::FloatGrid& grid) { openvdb::tools::sdfToFogVolume(grid); }

void make_distances(openvdb::FloatGrid& grid) {
  openvdb::FloatTree& tree = grid.tree();
  const float half_width = tree.background();
  const TreeNodes<openvdb::FloatTree> nodes(tree);
  tbb::parallel_for(std::size_t{0}, nodes.leaves.size(), [&](std::size_t n) {
    auto& leaf = *nodes.leaves[n];
    for (openvdb::Index i = 0; i < leaf.SIZE; ++i) {
      leaf.setValueOnly(i, half_width - leaf.getValue(i));
      leaf.setActiveState(i, leaf.getValue(i) != 0.0f);
    }
  });
  // Inactive tiles lie both inside and outside.
  nodes.for_each_with_tiles([&](auto& node, int) {
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
