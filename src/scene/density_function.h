#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>

#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/transfer_function.h"

namespace psivox {

/// Values at the ends of the scene's colour map: the given ones, else the density's least and
/// greatest active values. If these are equal, the range is from that value to 0, or from 0 to 1 if
/// it is 0. Unset if the scene has no colour map.
std::optional<glm::dvec2> resolved_range(const Scene& scene, const Field& density);

/// The scene's transfer function or colour map over the density's values; null if it has none.
/// Throws Error(input). Throws Error(usage) if both the function and a grid would give the
/// luminance, or if an option of the scene does not work with a function of the gradient.
std::shared_ptr<const TransferFunction> density_function(const Scene& scene, const Field& density);

}  // namespace psivox
