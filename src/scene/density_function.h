#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>

#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/transfer_function.h"

namespace psivox {

/// Values at the ends of the scene's colour map: the given ones, else the density's least and
/// greatest active value; where these are one value, that and 0 (of 0 alone: 0 and 1). Nothing
/// where the scene has no colour map.
std::optional<glm::dvec2> resolved_range(const Scene& scene, const Field& density);

/// The scene's transfer function or colour map over the density's values; null where it has none.
/// Throws Error(input), Error(usage) where both the function and a grid would give the luminance,
/// or where the scene asks of a function of the gradient what only one of the value alone can do.
std::shared_ptr<const TransferFunction> density_function(const Scene& scene, const Field& density);

}  // namespace psivox
