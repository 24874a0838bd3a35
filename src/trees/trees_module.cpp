// The module psivox_trees: what OpenVDB itself does.

#include <openvdb/io/Stream.h>
#include <openvdb/io/io.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/GridTransformer.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tree/NodeManager.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "base/text.h"
#include "field/index_space.h"
#include "vdb/trees.h"

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

openvdb::Coord coord_of(const glm::ivec3& at) { return {at.x, at.y, at.z}; }
glm::ivec3 place_of(const openvdb::Coord& at) { return {at.x(), at.y(), at.z()}; }
glm::dvec3 point_of(const openvdb::Vec3d& at) { return {at[0], at[1], at[2]}; }

float our_value(float value) { return value; }
glm::vec3 our_value(const openvdb::Vec3f& value) { return {value[0], value[1], value[2]}; }

float* floats_of(float* values) { return values; }
float* floats_of(openvdb::Vec3f* values) { return values->asPointer(); }

template <typename GridT>
openvdb::GridBase::Ptr tree_of(const TreeSource& from) {
  using ValueT = typename GridT::ValueType;
  using LeafT = typename GridT::TreeType::LeafNodeType;
  // OpenVDB's library makes it, because GridT::create() would compile the type's reading, writing
  // and copying once more, which takes 10 s
  const auto grid = openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
  auto& root = grid->tree().root();
  const Topology& topology = from.topology;
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
    leaves[n]->setValueMask(leaf.active());
  });
  return grid;
}

/// Takes the voxels of a grid, which keeps their values.
template <typename GridT>
void take_voxels(GridT& grid, ConvertedGrid& made) {
  TopologyBuilder<decltype(our_value(grid.background()))> found({});
  found.set_background(our_value(grid.background()));
  Voxels& voxels = made.voxels;
  each_node(grid.tree(), false, [&]<typename NodeT>(NodeT& node) {
    if constexpr (NodeT::LEVEL == 0) {
      found.add_leaf(place_of(node.origin()), node.getValueMask());
      voxels.leaves.push_back(floats_of(node.buffer().data()));
      voxels.active.push_back(node.getValueMask());
    } else {
      for (auto it = node.cbeginValueAll(); it; ++it)
        found.add_tile(place_of(it.getCoord()), int(NodeT::ChildNodeType::DIM), our_value(*it),
                       it.isValueOn());
    }
  });
  Topology topology = found.take();
  made.summary = topology.summary;
  made.origins = std::move(topology.leaves);
  voxels.tiles = std::move(topology.tiles);
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
    const glm::ivec3 at = corner_of({place_of(box.min()), place_of(box.max())}, corner);
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

/// Gives a level set whose file has the background 0, such as the surface of a liquid in Blender's
/// caches, the greatest of its distances as background. Values on both sides of 0 tell that it is
/// one; others stay as they are.
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

/// Makes the level set half width - distance: the background is 0, and voxels are active where the
/// value is not 0, in the outer band and everywhere inside.
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

openvdb::math::Transform::Ptr transform_of(const std::string& frustum) {
  constexpr std::string_view map = "NonlinearFrustumMap";
  const auto length = static_cast<std::uint32_t>(map.size());
  std::istringstream stream(std::string(reinterpret_cast<const char*>(&length), sizeof length)
                                .append(map)
                                .append(frustum));
  openvdb::io::setCurrentVersion(stream);
  const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
  transform->read(stream);
  return transform;
}

/// Resamples a grid with a frustum transform into cubic voxels as small as its smallest. Throws
/// std::runtime_error with the rest of a sentence if the grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, ConvertedGrid& made) {
  const Lattice lattice = lattice_of(*grid);
  const auto transform = openvdb::math::Transform::createLinearTransform(lattice.voxel_size);
  transform->postTranslate(lattice.origin);
  for (int axis = 0; axis < 3; ++axis) made.world_from_index[axis][axis] = lattice.voxel_size;
  made.world_from_index[3] = glm::dvec4(point_of(lattice.origin), 1);

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

ConvertedGrid convert(const TreeSource& from, const ReadOptions& options) {
  ConvertedGrid made;
  made.world_from_index = from.head.transform.world_from_index;
  openvdb::GridBase::Ptr tree = from.topology.summary.channels == 3
                                    ? tree_of<openvdb::Vec3SGrid>(from)
                                    : tree_of<openvdb::FloatGrid>(from);
  const bool level_set = is_level_set(from.head, from.topology.summary);
  if (level_set || is_fog_of_wrong_class(from.head, from.topology.summary)) {
    auto& floats = static_cast<openvdb::FloatGrid&>(*tree);
    if (!level_set) complete_level_set(floats);
    made.wrong_class = floats.background() == 0;
    if (!made.wrong_class) convert_level_set(floats, options, made);
  }
  if (!from.head.transform.is_linear()) {
    if (options.strict)
      throw std::runtime_error(
          "has a frustum transform, which strict reading does not resample; resample it where"
          " the file is made");
    tree->setTransform(transform_of(from.head.transform.frustum));
    tree = resample_to_linear(tree, made);
  }
  tree->apply<FloatGrids>([&](auto& typed) { take_voxels(typed, made); });
  made.voxels.storage = tree;
  return made;
}

FrustumPlace place(const std::string& bytes, const Box& active_box) {
  const auto transform = transform_of(bytes);
  FrustumPlace place{point_of(transform->voxelSize()), {}, {}};
  if (!active_box.empty())
    std::tie(place.world_min, place.world_max) =
        bounds_of(active_box, [&](const glm::dvec3& index) {
          return point_of(transform->indexToWorld(openvdb::Vec3d(index.x, index.y, index.z)));
        });
  return place;
}

using Grids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid,
                                openvdb::Int64Grid, openvdb::BoolGrid, openvdb::Vec3SGrid,
                                openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

/// Throws if the root of a grid's tree has nodes or tiles at places where none can be. OpenVDB
/// would compute ends beyond the integers from them.
void check_root(const openvdb::GridBase& grid) {
  grid.apply<Grids>([](const auto& typed) {
    const auto& root = typed.tree().root();
    constexpr int width = std::decay_t<decltype(root)>::ChildNodeType::DIM;
    for (auto it = root.cbeginChildAll(); it; ++it)
      if ((it.getCoord() & ~(width - 1)) != it.getCoord())
        throw std::runtime_error("a node of its root is at an impossible place");
  });
}

/// A file of grids that OpenVDB reads.
class OldFile : private openvdb::io::Archive {
 public:
  explicit OldFile(FileBlocks& file) : buffer_(file) {
    stream_.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(stream_);
    // OpenVDB's readers ask the stream for these
    metadata_.reset(new openvdb::io::StreamMetadata);
    metadata_->setSeekable(true);
    openvdb::io::setStreamMetadataPtr(stream_, metadata_, /*transfer=*/false);
    setFormatVersion(stream_);
    setLibraryVersion(stream_);
    setDataCompression(stream_);
  }

  openvdb::GridBase::Ptr read(const OldGrid& from) {
    const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(from.type);
    grid->setSaveFloatAsHalf(from.half);
    openvdb::io::GridDescriptor descriptor("", from.type, from.half);
    descriptor.setGridPos(from.begin);
    descriptor.setEndPos(from.end);
    stream_.clear();
    stream_.seekg(from.begin);
    buffer_.expect(from.end - from.begin);
    readGrid(grid, descriptor, stream_);
    check_root(*grid);
    return grid;
  }

  std::int64_t end_of_last() { return stream_.tellg(); }

 private:
  FileBuffer buffer_;
  std::istream stream_{&buffer_};              ///< throws where the file ends
  openvdb::io::StreamMetadata::Ptr metadata_;  ///< the stream keeps a plain pointer to it
};

RewrittenGrid rewritten(FileBlocks& file, const OldGrid& grid, const OldGrid* parent) {
  OldFile old(file);
  const openvdb::GridBase::Ptr read = old.read(grid);
  const std::int64_t end = old.end_of_last();
  if (parent) read->setTree(old.read(*parent)->baseTreePtr());
  std::ostringstream out;
  openvdb::io::Stream stream(out);
  stream.setCompression(openvdb::io::COMPRESS_NONE);
  stream.write(openvdb::GridCPtrVec{read});
  return {std::move(out).str(), end};
}

constexpr Trees table = {openvdb::getLibraryVersionString, convert, place, rewritten};

}  // namespace
}  // namespace psivox::vdb

extern "C" const psivox::vdb::Trees* psivox_trees() {
  openvdb::initialize();
  return &psivox::vdb::table;
}
