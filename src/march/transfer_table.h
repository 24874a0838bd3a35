#pragma once

#include <glm/vec4.hpp>
#include <optional>
#include <vector>

#include "psivox/transfer_function.h"

namespace psivox {

/// A transfer function as shaders/transfer.glsl reads it: four entries a knot,
///   (value, attenuation, and what is to be added to either for the next knot's)
///   (colour, integral of the attenuation from the first knot)
///   (what is to be added to the colour for the next knot's, 0)
///   (integral of attenuation times colour from the first knot, 0)
/// then `bins` entries: the first and the last interval that a value of that bin may lie in, and
/// the value at which the last one begins.
struct TransferTable {
  std::vector<glm::vec4> entries;
  int knots = 0;  ///< at least 2
  int bins = 0;
  int search_steps = 0;  ///< most that the bisection inside a bin takes
  double min = 0;        ///< value of the first knot
  double bin_scale = 0;  ///< bins per unit of value
};

/// Its gradient part: an entry (gradient, next gradient, 0, 0) for each interval of gradients, then
/// for each interval k of values and j of gradients the attenuations at (k, j), (k, j + 1),
/// (k + 1, j), (k + 1, j + 1), j minor; then (value, thickness, attenuation, 0) an isosurface. At
/// least one interval of each.
struct GradientEntries {
  std::vector<glm::vec4> entries;
  int columns = 1;  ///< intervals of gradients
  int isosurfaces = 0;
  int search_steps = 0;  ///< most that the bisection of the gradients takes
};

GradientEntries make_gradient_entries(const TransferFunction& function);

TransferTable make_transfer_table(const TransferFunction& function);

/// An attenuation that never falls, as a constant and ramps: each is 0 up to its knot and linear
/// from there on. A look-up reads no table.
struct Ramps {
  double base = 0;
  glm::dvec4 knots{0}, slopes{0};  ///< those that are not needed have slope 0
};

/// Nothing if the attenuation falls, bends more than four times, depends on the gradient, or is so
/// steep that the ramps' sum would cancel.
std::optional<Ramps> make_ramps(const TransferFunction& function);

}  // namespace psivox
