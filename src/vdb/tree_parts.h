#pragma once

#include <openvdb/openvdb.h>

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "psivox/field.h"

namespace psivox::vdb {

/// A value in a tree's node that fills a cube of voxels.
struct TilePart {
  Tile tile;
  bool active;
};

/// A tree without its voxels' type, so that all later code is compiled once.
struct TreeParts {
  int channels = 1;
  /// The 512 * channels values of each leaf as floats, vectors interleaved, in the tree's order.
  std::vector<float*> leaves;
  std::vector<openvdb::Coord> origins;                    ///< of each leaf
  std::vector<const openvdb::util::NodeMask<3>*> active;  ///< active voxels of each leaf
  /// Tiles of the root first, then those 128 voxels wide, then those 8 voxels wide, without
  /// inactive tiles of the background's value.
  std::vector<TilePart> tiles;
  std::shared_ptr<const void> storage;  ///< keeps `leaves` alive
};

inline glm::ivec3 to_ivec3(const openvdb::Coord& c) { return {c.x(), c.y(), c.z()}; }

/// The grid's leaves and tiles. Values of a float or vec3s grid stay in place; others are
/// converted. `active` points into the grid. The grid's type must be one of SupportedGrids.
TreeParts parts_of(const openvdb::GridBase::Ptr& grid);

/// The same of a scalar that is 1 at active voxels and 0 elsewhere. The grid's values may be unset.
TreeParts active_parts_of(const openvdb::GridBase::Ptr& grid);

/// Least and greatest of the first channel of active voxels and tiles; NaN and Inf in tiles do not
/// count, and leaves must have none.
glm::vec2 active_range(const TreeParts& parts);

/// For each of some percentages, the smallest value of the first channel that at least so many of
/// the active voxels do not exceed. A tile counts as its voxels.
std::map<double, double> active_percentiles(const TreeParts& parts,
                                            std::span<const double> percents);

}  // namespace psivox::vdb
