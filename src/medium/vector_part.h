#pragma once

#include <string>

#include "psivox/field.h"
#include "psivox/vdb.h"

namespace psivox {

/// A scalar of a grid: x, y, z or length of vectors, or where any grid is active.
struct VectorPart {
  std::string grid;
  std::string part;  ///< `x`, `y`, `z`, `length` or `active`; empty: the grid is scalar
  bool active() const { return part == "active"; }
  bool of_vectors() const { return !part.empty() && !active(); }
};

/// The meaning of --grid: `velocity:x`, `velocity:active`, or a grid's name. The length if the grid
/// has vectors and no part is named. Throws Error(input) if x, y, z or length of a scalar grid is
/// named.
VectorPart vector_part(const VdbFile& file, const std::string& name);

/// The scalar field, called `velocity:x`.
Field part_of_vectors(const Field& vectors, const VectorPart& part);

}  // namespace psivox
