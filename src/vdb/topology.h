#pragma once

#include <openvdb/openvdb.h>

#include <cstdint>
#include <istream>
#include <optional>
#include <vector>

#include "grid_types.h"
#include "psivox/field.h"
#include "survey.h"

namespace psivox::vdb {

/// A value in a tree's node that fills a cube of voxels. As double it keeps the grid's own type.
struct TilePart {
  glm::ivec3 origin;
  int width;
  glm::dvec3 value;
  bool active;

  Tile tile() const { return {origin, width, glm::vec3(value)}; }
};

/// A grid's tree without values of leaves.
struct Topology {
  std::vector<glm::ivec3> leaves;     ///< their origins, in the tree's order
  std::vector<std::uint16_t> active;  ///< voxels of each leaf
  std::vector<LeafMask> masks;        ///< of each leaf, if wanted
  /// Tiles of the root first, then those 128 voxels wide, then those 8 voxels wide, without
  /// inactive tiles of the background's value.
  std::vector<TilePart> tiles;
  GridSummary summary;
};

struct TopologyWish {
  bool masks = false;
  std::optional<glm::dvec3> background = {};  ///< inactive tiles of the background have this value
};

/// Reads the topology of a grid from the stream, which is at its tree, in a few bytes a leaf: no
/// node is made. The file's format must be 222 or later. The grid, which is empty, gets the tree's
/// background. Throws if the file is damaged.
Topology read_topology(openvdb::GridBase& empty, std::istream& stream,
                       const TopologyWish& wish = {});

}  // namespace psivox::vdb
