#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <istream>

namespace psivox::vdb {

/// Sets the voxels of a grid to the numbers of points in them. Its topology has just been read from
/// the stream, which is at the leaves of a grid of points (OpenVDB's PointDataGrid, file format 224
/// or later). Attributes of points are passed over, so that their types and codecs do not matter.
/// Leaves the stream before the attributes' values, and returns how many bytes those take. Throws
/// if the file is damaged.
std::int64_t read_point_counts(openvdb::Int32Grid& grid, std::istream& stream);

}  // namespace psivox::vdb
