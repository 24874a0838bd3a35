#include <openvdb/openvdb.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tree/NodeManager.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "archives.h"
#include "base/text.h"
#include "field/index_space.h"
#include "topology_builder.h"

namespace psivox::vdb {
namespace {

using FloatGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Vec3SGrid>;

/// Upper bound of the resampled box: 256 MiB of floats if every voxel is active.
constexpr double kMaxResampledVoxels = 67108864;  // 2^26

/// Calls op(node) for the root, each inner node and each leaf, from the root down, in all threads.
template <typename TreeT, typename Op>
void each_node(TreeT& tree, const Op& op) {
  openvdb::tree::NodeManager<TreeT>(tree).foreachTopDown(op);
}

template <typename ValueT>
ValueT value_of(const glm::vec3& value) {
  if constexpr (openvdb::VecTraits<ValueT>::IsVec)
    return ValueT(value.x, value.y, value.z);
  else
    return value.x;
}

openvdb::Coord coord_of(const glm::ivec3& at) { return {at.x, at.y, at.z}; }
glm::dvec3 point_of(const openvdb::Vec3d& at) { return {at[0], at[1], at[2]}; }

float* floats_of(float* values) { return values; }
float* floats_of(openvdb::Vec3f* values) { return values->asPointer(); }

template <typename GridT>
openvdb::GridBase::Ptr tree_of(FileGrid& from) {
  using ValueT = typename GridT::ValueType;
  using LeafT = typename GridT::TreeType::LeafNodeType;
  // OpenVDB's library makes it, because GridT::create() would compile the type's reading, writing
  // and copying once more, which takes 10 s
  const auto grid = openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
  auto& root = grid->tree().root();
  const Topology& topology = from.topology();
  root.setBackground(value_of<ValueT>(glm::vec3(topology.summary.background)),
                     /*updateChildNodes=*/false);
  for (const TilePart& tile : topology.tiles) {
    const openvdb::Index level = tile.width == LeafT::DIM ? 1 : tile.width == 128 ? 2 : 3;
    root.addTile(level, coord_of(tile.origin), value_of<ValueT>(glm::vec3(tile.value)),
                 tile.active);
  }
  std::vector<LeafT*> leaves;
  leaves.reserve(topology.leaves.size());
  for (const glm::ivec3& origin : topology.leaves) {
    leaves.push_back(new LeafT(coord_of(origin)));
    root.addLeaf(leaves.back());
  }
  from.each_leaf([&](std::size_t n, const DecodedLeaf& leaf) {
    leaf.copy_to(floats_of(leaves[n]->buffer().data()));
    typename LeafT::NodeMaskType active;
    std::memcpy(static_cast<void*>(&active), &leaf.active(), sizeof active);
    leaves[n]->setValueMask(active);
  });
  return grid;
}

/// Takes the voxels of a grid, which keeps their values.
template <typename GridT>
void take_voxels(GridT& grid, ConvertedGrid& made) {
  TopologyBuilder<typename GridT::ValueType> found({}, grid.background());
  take_nodes(grid.tree().root(), found,
             [&](auto& leaf) { made.values.push_back(floats_of(leaf.buffer().data())); });
  made.topology = found.take();
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
  glm::dvec3 origin;  ///< world position of index (0,0,0)
  double voxel_size;
  bool coarsened;  ///< to respect kMaxResampledVoxels
};

/// The lattice of cubic voxels over the world box of the active voxels.
Lattice lattice_of(const openvdb::GridBase& grid) {
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  const openvdb::math::Transform& transform = grid.transform();
  double voxel_size = std::numeric_limits<double>::infinity();
  const auto place = [&](const glm::dvec3& at) {
    const openvdb::Vec3d index(at.x, at.y, at.z), size = transform.voxelSize(index);
    voxel_size = std::min({voxel_size, size[0], size[1], size[2]});
    return point_of(transform.indexToWorld(index));
  };
  const auto [lo, hi] = bounds_of({place_of(box.min()), place_of(box.max())}, place);
  const glm::dvec3 extent = hi - lo;
  if (!(voxel_size > 0.0) || !std::isfinite(glm::length(extent))) {
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

/// Gives a level set whose file has the background 0, such as the surface of a liquid in Blender's
/// caches, the greatest of its distances as background. Values on both sides of 0 tell that it is
/// one; others stay as they are.
void complete_level_set(openvdb::FloatGrid& grid) {
  const glm::vec2 bounds = active_bounds(grid);
  if (!(bounds.x < 0 && bounds.y > 0)) return;
  const float outside = bounds.y;
  each_node(grid.tree(), [&](auto& node) {
    for (auto off = node.beginValueOff(); off; ++off)
      if (off.getValue() == 0) off.setValue(outside);
  });
  grid.tree().root().setBackground(outside, /*updateChildNodes=*/false);
}

/// Makes the level set half width - distance: the background is 0, and voxels are active where the
/// value is not 0, in the outer band and everywhere inside.
void make_distances(openvdb::FloatGrid& grid) {
  openvdb::FloatTree& tree = grid.tree();
  const float half_width = tree.background();
  // Inactive tiles lie both inside and outside.
  each_node(tree, [&](auto& node) {
    for (auto it = node.beginValueAll(); it; ++it) {
      it.setValue(half_width - *it);
      it.setValueOn(*it != 0.0f);
    }
  });
  // Changes the root only; elsewhere the background is in tiles and voxels, which are converted.
  tree.root().setBackground(0.0f, /*updateChildNodes=*/false);
}

/// Makes a level set a fog volume (0 at the surface and outside, rising to 1 at the depth of its
/// narrow band), by OpenVDB's own conversion, or distances.
void convert_level_set(openvdb::FloatGrid& tree, const ReadOptions& options, ConvertedGrid& made) {
  if (options.distances) {
    made.half_width = double(tree.background());
    make_distances(tree);
    made.notices.push_back(
        formatted("level set kept as distances, which it has within %g [world units] of its "
                  "surface",
                  made.half_width));
  } else {
    openvdb::tools::sdfToFogVolume(tree);
    made.notices.push_back(
        "level set converted to fog: 0 at its surface, 1 at the depth of its narrow band");
  }
  if (tree.activeVoxelCount() == 0)
    throw std::runtime_error("is a level set without an inside: nothing to render");
}

const openvdb::math::Transform& frustum_of(const Transform& transform) {
  return *static_cast<const openvdb::math::Transform*>(transform.frustum.get());
}

/// Resamples a grid with a frustum transform into cubic voxels as small as its smallest. Throws
/// std::runtime_error with the rest of a sentence if the grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, ConvertedGrid& made) {
  const Lattice lattice = lattice_of(*grid);
  const auto transform = openvdb::math::Transform::createLinearTransform(lattice.voxel_size);
  const glm::dvec3& origin = lattice.origin;
  transform->postTranslate(openvdb::Vec3d(origin.x, origin.y, origin.z));
  for (int axis = 0; axis < 3; ++axis) made.world_from_index[axis][axis] = lattice.voxel_size;
  made.world_from_index[3] = glm::dvec4(origin, 1);

  openvdb::GridBase::Ptr result = grid->copyGridWithNewTree();
  result->setTransform(transform);
  grid->apply<FloatGrids>([&](const auto& from) {
    using GridT = std::decay_t<decltype(from)>;
    openvdb::tools::resampleToMatch<openvdb::tools::BoxSampler>(
        from, *openvdb::gridPtrCast<GridT>(result));
  });
  made.notices.push_back(
      formatted("frustum transform resampled to cubic voxels of size %g", lattice.voxel_size) +
      (lattice.coarsened ? " (larger than its smallest, to save memory)" : ""));
  return result;
}

}  // namespace

ConvertedGrid convert(FileGrid& from, const ReadOptions& options) {
  const Transform& transform = from.head().transform;
  ConvertedGrid made;
  made.world_from_index = transform.world_from_index;
  openvdb::GridBase::Ptr tree =
      from.channels() == 3 ? tree_of<openvdb::Vec3SGrid>(from) : tree_of<openvdb::FloatGrid>(from);
  const bool level_set = is_level_set(from.head(), from.summary());
  if (level_set || is_fog_of_wrong_class(from.head(), from.summary())) {
    auto& floats = static_cast<openvdb::FloatGrid&>(*tree);
    if (!level_set) complete_level_set(floats);
    made.wrong_class = floats.background() == 0;
    if (!made.wrong_class) convert_level_set(floats, options, made);
  }
  if (!transform.is_linear()) {
    if (options.strict)
      throw std::runtime_error(
          "has a frustum transform, which strict reading does not resample; resample it where"
          " the file is made");
    tree->setTransform(frustum_of(transform).copy());
    tree = resample_to_linear(tree, made);
  }
  tree->apply<FloatGrids>([&](auto& typed) { take_voxels(typed, made); });
  made.storage = tree;
  return made;
}

FrustumPlace place(const Transform& frustum, const Box& active_box) {
  const openvdb::math::Transform& transform = frustum_of(frustum);
  FrustumPlace place{point_of(transform.voxelSize()), {}, {}};
  if (!active_box.empty())
    std::tie(place.world_min, place.world_max) =
        bounds_of(active_box, [&](const glm::dvec3& index) {
          return point_of(transform.indexToWorld(openvdb::Vec3d(index.x, index.y, index.z)));
        });
  return place;
}

}  // namespace psivox::vdb
