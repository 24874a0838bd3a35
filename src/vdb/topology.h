#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <istream>
#include <vector>

#include "grid_check.h"
#include "tree_parts.h"

namespace psivox::vdb {

/// A grid's tree without values of leaves.
struct Topology {
  std::vector<glm::ivec3> leaves;     ///< their origins, in the tree's order
  std::vector<std::uint16_t> active;  ///< voxels of each leaf
  std::vector<TilePart> tiles;        ///< as TreeParts::tiles
  GridSummary summary;
};

/// Reads the topology of a grid from the stream, which is at its tree, in a few bytes a leaf: no
/// node is made. The file's format must be 222 or later. The grid, which is empty, gets the tree's
/// background. Throws if the file is damaged.
Topology read_topology(openvdb::GridBase& empty, std::istream& stream);

}  // namespace psivox::vdb
