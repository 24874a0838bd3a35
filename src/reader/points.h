#pragma once

#include <openvdb/points/PointDataGrid.h>

#include <istream>

namespace psivox::vdb {

/// Reads the leaves of a grid of points from the stream, which is behind the topology: the offsets
/// of the points in each voxel, and the values of attributes if `whole` is set. `coding` is the
/// stream's.
/// Throws if an attribute's type is not registered.
void read_points(openvdb::points::PointDataGrid& grid, std::istream& stream,
                 openvdb::io::StreamMetadata& coding, bool whole);

}  // namespace psivox::vdb
