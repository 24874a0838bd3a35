#include "conform.h"

#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "grid_check.h"
#include "grid_types.h"
#include "sanitise.h"
#include "tree_nodes.h"
#include "tree_parts.h"

namespace psivox::vdb {
namespace {

/// Upper bound of the resampled box: 256 MiB of floats if every voxel is active.
constexpr double kMaxResampledVoxels = 67108864;  // 2^26

template <typename GridT>
openvdb::GridBase::Ptr grid_of(const TreeParts& parts, const openvdb::Vec3d& background) {
  using TreeT = typename GridT::TreeType;
  using ValueT = typename GridT::ValueType;
  using LeafT = typename TreeT::LeafNodeType;
  constexpr bool is_vec = openvdb::VecTraits<ValueT>::IsVec;
  const auto value_of = [](const auto& v) {
    if constexpr (is_vec)
      return ValueT(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]));
    else
      return static_cast<float>(v[0]);
  };
  const auto grid = new_grid<GridT>();
  auto& root = grid->tree().root();
  root.setBackground(value_of(background), /*updateChildNodes=*/false);
  for (const TilePart& part : parts.tiles) {
    const Tile& tile = part.tile;
    const openvdb::Index level = tile.width == LeafT::DIM ? 1 : tile.width == 128 ? 2 : 3;
    root.addTile(level, openvdb::Coord(tile.origin.x, tile.origin.y, tile.origin.z),
                 value_of(tile.value), part.active);
  }
  for (std::size_t n = 0; n < parts.leaves.size(); ++n) {
    auto* leaf = new LeafT(parts.origins[n]);
    const auto* values = reinterpret_cast<const ValueT*>(parts.leaves[n]);
    std::copy(values, values + kLeafVoxels, leaf->buffer().data());
    leaf->setValueMask(*parts.active[n]);
    root.addLeaf(leaf);
  }
  return grid;
}

/// A copy with float components; the same grid if it has them already.
openvdb::GridBase::Ptr float_copy(const openvdb::GridBase::Ptr& grid) {
  if (grid->isType<openvdb::FloatGrid>() || grid->isType<openvdb::Vec3SGrid>()) return grid;
  const TreeParts parts = parts_of(grid);
  const openvdb::Vec3d background = summarise(*grid).background;
  const auto copy = parts.channels == 3 ? grid_of<openvdb::Vec3SGrid>(parts, background)
                                        : grid_of<openvdb::FloatGrid>(parts, background);
  copy->insertMeta(*grid);
  copy->setTransform(grid->transform().copy());
  return copy;
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

openvdb::GridBase::Ptr activity_of(const openvdb::GridBase::Ptr& grid) {
  const auto result = grid_of<openvdb::FloatGrid>(active_parts_of(grid), openvdb::Vec3d(0.0));
  result->insertMeta(*grid);
  result->setTransform(grid->transform().copy());
  result->setGridClass(openvdb::GRID_UNKNOWN);
  return result;
}

openvdb::GridBase::Ptr fog_from_level_set(const openvdb::GridBase::Ptr& grid) {
  openvdb::GridBase::Ptr fog = float_copy(grid);
  openvdb::tools::sdfToFogVolume(*openvdb::gridPtrCast<openvdb::FloatGrid>(fog));
  return fog;
}

openvdb::GridBase::Ptr distances_from_level_set(const openvdb::GridBase::Ptr& grid) {
  openvdb::GridBase::Ptr result = float_copy(grid);
  openvdb::FloatTree& tree = openvdb::gridPtrCast<openvdb::FloatGrid>(result)->tree();
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
  result->setGridClass(openvdb::GRID_UNKNOWN);
  return result;
}

openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice) {
  const openvdb::GridBase::Ptr source = float_copy(grid);
  const Lattice lattice = lattice_of(*source);
  const auto transform = openvdb::math::Transform::createLinearTransform(lattice.voxel_size);
  transform->postTranslate(lattice.origin);

  openvdb::GridBase::Ptr result = source->copyGridWithNewTree();
  result->setTransform(transform);
  // Whatever the class says, the values are not distances (any more), so no level set is rebuilt.
  source->setGridClass(openvdb::GRID_UNKNOWN);
  const auto resample = [&](const auto& from) {
    using GridT = std::decay_t<decltype(from)>;
    openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(
        from, *openvdb::gridPtrCast<GridT>(result));
  };
  using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>;
  source->apply<FloatGrids>(resample);

  std::ostringstream text;
  text << "frustum transform resampled to cubic voxels of size " << lattice.voxel_size
       << (lattice.coarsened ? " (larger than its smallest, to save memory)" : "");
  notice = text.str();
  return result;
}

}  // namespace psivox::vdb
