#pragma once

#include <openvdb/openvdb.h>

#include <memory>
#include <string>
#include <vector>

#include "file_grid.h"
#include "survey.h"
#include "topology.h"

// Trees of OpenVDB, for the conversions that need one.

namespace psivox::vdb {

/// A float or vec3s grid with the values, metadata and transform of the file's grid.
openvdb::GridBase::Ptr float_tree(FileGrid& grid);

/// What a field takes from a grid's voxels.
struct Voxels {
  std::vector<float*> leaves;    ///< the 512 * channels values of each leaf, vectors interleaved
  std::vector<LeafMask> active;  ///< of each leaf
  std::vector<TilePart> tiles;   ///< as Topology::tiles
  std::shared_ptr<const void> storage;  ///< keeps `leaves` alive
};

/// The voxels of such a grid, whose values stay in place. Sets the summary and the leaves' origins.
Voxels voxels_of(const openvdb::GridBase::Ptr& grid, GridSummary& summary,
                 std::vector<glm::ivec3>& origins);

/// Gives a level set whose file has the background 0, such as the surface of a liquid in Blender's
/// caches, the greatest of its distances as background. Class and values on both sides of 0 tell
/// that it is one; others stay as they are.
void complete_level_set(openvdb::FloatGrid& grid);

/// Makes the level set a fog volume (0 at the surface and outside, rising to 1 at the depth of its
/// narrow band), by OpenVDB's own conversion.
void make_fog(openvdb::FloatGrid& grid);

/// Makes the level set half width - distance: the background is 0, and voxels are active where the
/// value is not 0, in the outer band and everywhere inside. The class becomes unknown.
void make_distances(openvdb::FloatGrid& grid);

/// A grid with a frustum transform, resampled with an affine transform into cubic voxels as small
/// as its smallest.
///
/// Sets `notice` to a sentence about the conversion. Throws std::runtime_error with the rest of a
/// sentence if the grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice);

}  // namespace psivox::vdb
