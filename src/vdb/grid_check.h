#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <string>

#include "psivox/field.h"

namespace psivox::vdb {

/// Facts about a tree for the checks and the info rows.
struct GridSummary {
  int channels = 0;                 ///< 0 if the type is not supported; then all others are unset
  std::uint64_t active_voxels = 0;  ///< active tiles count with all their voxels
  std::uint64_t leaves = 0;
  std::uint64_t active_tiles = 0;
  Box active_box;
  openvdb::Vec3d background{0.0};  ///< a scalar's in every component
};

GridSummary summarise(const openvdb::GridBase& grid);

/// Whether coordinates would overflow: the box is 2^30 voxels wide or that far from the origin.
bool too_large(const Box& box);

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
