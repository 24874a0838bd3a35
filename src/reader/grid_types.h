#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <cstdint>
#include <istream>

namespace psivox::vdb {

/// OpenVDB has it since version 13.
using HalfGrid = openvdb::Grid<openvdb::tree::Tree4<openvdb::math::half, 5, 4, 3>::Type>;

using SupportedGrids =
    openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, HalfGrid, openvdb::Int32Grid,
                      openvdb::Int64Grid, openvdb::BoolGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid,
                      openvdb::Vec3IGrid, openvdb::MaskGrid, openvdb::points::PointDataGrid>;

/// Reads the leaves of a grid of points from the stream, which is behind the topology: the offsets
/// of the points in each voxel, and the values of attributes if `whole` is set. `coding` is the
/// stream's. Throws if an attribute's type is not registered.
inline void read_points(openvdb::points::PointDataGrid& grid, std::istream& stream,
                        openvdb::io::StreamMetadata& coding, bool whole) {
  std::uint16_t passes = 0;
  stream.read(reinterpret_cast<char*>(&passes), sizeof passes);
  if (grid.tree().leafCount() == 0) return;
  // a pass goes over all leaves; the one in the middle has the offsets, attributes follow
  const std::uint32_t wanted = whole ? passes : passes / 2u + 1;
  for (std::uint32_t pass = 0; pass < wanted; ++pass) {
    coding.setPass(std::uint32_t(passes) << 16 | pass);
    grid.tree().readBuffers(stream, coding.halfFloat());
  }
}

}  // namespace psivox::vdb
