#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grid_file.h"
#include "psivox/field.h"
#include "psivox/vdb.h"

// What VdbFile asks of a grid of a file: a field, a row of `info`, or whether it holds something.

namespace psivox::vdb {

/// What a field takes from a grid's voxels.
struct Voxels {
  std::vector<float*> leaves;    ///< the 512 * channels values of each leaf, vectors interleaved
  std::vector<LeafMask> active;  ///< of each leaf
  std::vector<TilePart> tiles;   ///< as Topology::tiles
  std::shared_ptr<const void> storage;  ///< keeps `leaves` alive
};

/// A field, and its voxels unless their values stay in the file.
struct ReadGrid {
  Field field;
  std::shared_ptr<const Voxels> voxels{};
};

/// Reads a grid, as VdbFile::read does, which says what is thrown.
ReadGrid read_grid(GridFile& file, const GridEntry& entry, const ReadOptions& options);

/// Finds in a field's voxels, none of which is bad, what the options ask for.
void look_again(Field& field, const Voxels& voxels, const ReadOptions& options);

// Trees of OpenVDB, for the conversions that need one.

/// A float or vec3s grid with the values, metadata and transform of the file's grid.
openvdb::GridBase::Ptr float_tree(FileGrid& grid);

/// The voxels of such a grid, whose values stay in place, and its topology.
Voxels voxels_of(const openvdb::GridBase::Ptr& grid, Topology& topology);

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
/// as its smallest. Sets `notice` to a sentence about the conversion. Throws std::runtime_error
/// with the rest of a sentence if the grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice);

}  // namespace psivox::vdb
