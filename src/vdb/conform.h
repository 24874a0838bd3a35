#pragma once

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

namespace psivox::vdb {

/// The level set as a fog volume (0 at the surface and outside, rising to 1 at the depth of its
/// narrow band), by OpenVDB's own conversion. The result is a float grid, possibly the given one,
/// changed.
openvdb::GridBase::Ptr fog_from_level_set(const openvdb::GridBase::Ptr& grid);

/// The level set as half width - distance: the background is 0, and voxels are active where the
/// value is not 0, in the outer band and everywhere inside. The result is a float grid of unknown
/// class, possibly the given one, changed.
openvdb::GridBase::Ptr distances_from_level_set(const openvdb::GridBase::Ptr& grid);

/// A float grid of unknown class that is 1 at the grid's active voxels and 0 elsewhere, with its
/// metadata and transform. The grid's values may be unset.
openvdb::GridBase::Ptr activity_of(const openvdb::GridBase::Ptr& grid);

/// A grid with a frustum transform, resampled with an affine transform into cubic voxels as small
/// as its smallest. The result is a float or vec3s grid.
///
/// Sets `notice` to a sentence about the conversion. Throws std::runtime_error with the rest of a
/// sentence if the grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice);

}  // namespace psivox::vdb
