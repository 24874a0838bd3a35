#pragma once

#include "psivox/medium.h"
#include "scene/transfer_function.h"

namespace psivox {

/// Luminance of black bodies [1 at 6500 K] at a grid's temperatures. The value 0 means 0 K whatever
/// the offset, because it is also the value of missing voxels. Throws Error(input) for vectors.
Field black_bodies(const Scene& scene, const Field& temperature);

/// Sets the source of the medium's luminance under the scene's mode, and the light that is still to
/// be computed. `function` maps the density's values, or is null. The medium must have its density
/// and transfer already. Throws Error(input).
void set_luminance(const Scene& scene, const MediumFields& fields,
                   const std::shared_ptr<const TransferFunction>& function, Medium& medium);

/// Bound of the luminance that the medium has before its light, without its `color`.
glm::dvec3 greatest_glow(const Medium& medium);

/// Whether a grid of that name holds colours.
bool names_colors(const std::string& grid);

/// A grid of colours as linear light. Bytes, whole numbers up to 255 of which some are above 1, and
/// numbers of which some are from 30 to 255, are sRGB codes; others are linear already.
Field linear_colors(Field colors);

}  // namespace psivox
