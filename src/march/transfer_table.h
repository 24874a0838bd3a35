#pragma once

#include <glm/vec4.hpp>
#include <vector>

#include "psivox/transfer_function.h"

namespace psivox {

/// A transfer function as shaders/transfer.glsl reads it: three entries a knot,
///   (value, attenuation, integral of the attenuation from the first knot, 0)
///   (colour, 0)
///   (integral of attenuation times colour from the first knot, 0)
/// then `bins` entries whose x and y are the first and the last interval that a value of that bin
/// may lie in.
struct TransferTable {
  std::vector<glm::vec4> entries;
  int knots = 0;  ///< at least 2
  int bins = 0;
  int search_steps = 0;  ///< most that the bisection inside a bin takes
  double min = 0;        ///< value of the first knot
  double bin_scale = 0;  ///< bins per unit of value
};

TransferTable make_transfer_table(const TransferFunction& function);

}  // namespace psivox
