#pragma once

#include <string>

#include "psivox/field.h"
#include "psivox/vdb.h"

namespace psivox {

/// A scalar of a grid of vectors: x, y or z, or the length.
struct VectorPart {
  std::string grid;
  std::string part;  ///< `x`, `y`, `z` or `length`; empty: the grid is scalar
};

/// The meaning of --grid: `velocity:x`, or a grid's name. The length if the grid has vectors and no
/// part is named. Throws Error(input) if a part of a scalar grid is named.
VectorPart vector_part(const VdbFile& file, const std::string& name);

/// The scalar field, called `velocity:x`.
Field part_of_vectors(const Field& vectors, const VectorPart& part);

}  // namespace psivox
