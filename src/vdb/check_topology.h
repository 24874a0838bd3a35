#pragma once

#include <openvdb/openvdb.h>

#include <istream>

namespace psivox::vdb {

/// Throws if a block of values between the masks of the grid's tree has an impossible length, which
/// OpenVDB's readTopology would believe. The stream is at the tree and stays there.
void check_topology(openvdb::GridBase& grid, std::istream& stream);

}  // namespace psivox::vdb
