#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <string>

#include "psivox/field.h"

namespace psivox::vdb {

#if OPENVDB_LIBRARY_MAJOR_VERSION_NUMBER >= 13
using RealGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::HalfGrid>;
#else  // which has no grids whose values are half floats in memory
using RealGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid>;
#endif

/// The grids that become a Field: scalars first, then those with three channels.
using SupportedGrids =
    RealGrids::Append<openvdb::Int32Grid, openvdb::Int64Grid, openvdb::BoolGrid, openvdb::Vec3SGrid,
                      openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

/// Grids of points, whose voxels become the numbers of points in them; and of active voxels without
/// values, which become 1.
bool is_points(const std::string& grid_type);
bool is_mask(const std::string& grid_type);
std::string points_grid_type();

/// The type of SupportedGrids whose topology is stored byte for byte as that of `grid_type`: int32
/// for points, bool for masks. Other types are stored as themselves.
std::string stored_like(const std::string& grid_type);

/// Channels of a grid type such as `Tree_float_5_4_3`: 1, 3, or 0 if it is not supported.
int channels_of(const std::string& grid_type);

/// GridInfo::value_type; empty if it is not supported.
std::string value_type_of(const std::string& grid_type);

/// Why a grid of an unsupported type cannot be rendered, as the rest of a sentence.
std::string unsupported_type(const std::string& grid_type);

/// Calls op(grid) with the grid's own type; false if that type is not supported.
template <typename Op>
bool with_typed_grid(const openvdb::GridBase& grid, Op&& op) {
  return grid.apply<SupportedGrids>(op);
}

/// An empty grid of background 0. OpenVDB's library makes it, because `GridT::create()` would
/// compile the type's reading, writing and copying once more, which takes 10 s.
template <typename GridT>
typename GridT::Ptr new_grid() {
  return openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
}

/// A level set in OpenVDB's sense that psivox can turn into fog: its class says so, its values are
/// floating-point scalars, and its background is the half width of its band.
bool is_level_set(const openvdb::GridBase& grid);
/// A grid of the same type and class whose background is 0, as a fog's is.
bool is_fog_of_wrong_class(const openvdb::GridBase& grid);

/// Facts about a tree for the checks and the info rows.
struct GridSummary {
  int channels = 0;
  std::uint64_t active_voxels = 0;  ///< active tiles count with all their voxels
  std::uint64_t leaves = 0;
  std::uint64_t active_tiles = 0;
  Box active_box;
  glm::dvec3 background{0};  ///< a scalar's in every component
};

/// Whether it has a background other than 0, and is no level set, whose background is its half
/// width.
bool has_background(const openvdb::GridBase& grid, const GridSummary& summary);

/// The background as text: 1, or (1, 1, 1).
std::string background_text(const GridSummary& summary);

/// Why the grid cannot be rendered, as the rest of a sentence that begins with its name; empty if
/// it can. Reading and `psivox info` both take these rules from here.
std::string problem_of(const openvdb::GridBase& grid, const GridSummary& summary);

/// The affine transform to world space in glm's convention (columns, acting on column vectors).
/// Meaningless unless the transform is linear; 0 if it is singular.
glm::dmat4 world_from_index(const openvdb::math::Transform& transform);

}  // namespace psivox::vdb
