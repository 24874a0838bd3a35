#pragma once

#include <openvdb/openvdb.h>

#include <string>
#include <vector>

namespace psivox::vdb {

/// The level set as a fog volume (0 at the surface and outside, rising to 1 at the depth of its
/// narrow band), by OpenVDB's own conversion. A float grid, which may be the given one changed.
openvdb::GridBase::Ptr fog_from_level_set(const openvdb::GridBase::Ptr& grid);

/// The level set as half width - distance: background 0, and active wherever it is not 0, that is
/// in the outer band and everywhere inside. A float grid, which may be the given one changed; its
/// class is unknown.
openvdb::GridBase::Ptr distances_from_level_set(const openvdb::GridBase::Ptr& grid);

/// The grid resampled into cubic voxels as small as the smallest of its own, with an affine
/// transform: for frustum transforms. A float or vec3s grid.
///
/// `notice` is set to what was done. Throws std::runtime_error with the rest of a sentence if the
/// grid's transform is unusable.
openvdb::GridBase::Ptr resample_to_linear(const openvdb::GridBase::Ptr& grid, std::string& notice);

}  // namespace psivox::vdb
