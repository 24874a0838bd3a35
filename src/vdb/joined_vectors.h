#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "vdb/reader.h"

namespace psivox::vdb {

/// Names of a vector's three scalar grids.
using Components = std::array<std::string, 3>;

/// Vectors that grids are the components of, by their names: `vel.x`, `vel.y` and `vel.z` make
/// `vel`, unless a grid has that name.
std::map<std::string, Components> vectors_of(const std::vector<GridFacts>& grids);

/// The vector field of three scalar ones, which lie on one lattice. If they are shifted against
/// each other by less than a voxel, as in a staggered grid, it lies in their middle, with a notice.
/// Throws Error(input), Error(memory).
Field joined_vectors(const std::string& name, const std::array<Field, 3>& components);

}  // namespace psivox::vdb
