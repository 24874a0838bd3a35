#pragma once

#include <openvdb/openvdb.h>

#include <istream>

namespace psivox::vdb {

/// Throws if a block of values between the masks of the grid's tree has an impossible length, which
/// OpenVDB's readTopology would believe. The stream is at the tree and stays there.
void check_topology(openvdb::GridBase& grid, std::istream& stream);

/// Throws if the root of a grid's tree has nodes or tiles at places where none can be. OpenVDB
/// would compute ends beyond the integers from them.
void check_root(const openvdb::GridBase& grid);

}  // namespace psivox::vdb
