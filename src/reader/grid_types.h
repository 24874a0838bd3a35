#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

namespace psivox::vdb {

/// OpenVDB has it since version 13.
using HalfGrid = openvdb::Grid<openvdb::tree::Tree4<openvdb::math::half, 5, 4, 3>::Type>;

using SupportedGrids =
    openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, HalfGrid, openvdb::Int32Grid,
                      openvdb::Int64Grid, openvdb::BoolGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid,
                      openvdb::Vec3IGrid, openvdb::MaskGrid, openvdb::points::PointDataGrid>;

}  // namespace psivox::vdb
