#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>

#include "psivox/field.h"
#include "psivox/scene.h"
#include "scene/transfer_function.h"

namespace psivox {

/// Values at the ends of the scene's range: the given ones, with percentiles as numbers. Else, for
/// maxima without a colour map, 0 and the greatest active value, and otherwise the least and the
/// greatest. If these are equal, the range is from that value to 0, or from 0 to 1 if it is 0.
/// Unset if the scene places no values in a range. Throws Error(usage) if the first percentile is
/// not below the second.
std::optional<glm::dvec2> resolved_range(const Scene& scene, const Field& density);

/// The scene's transfer function or colour map over the density's values; null if it has none.
/// Throws Error(input). Throws Error(usage) if both the function and a grid would give the
/// luminance, or if an option of the scene does not work with a function of the gradient.
std::shared_ptr<const TransferFunction> density_function(const Scene& scene, const Field& density);

/// Otsu's threshold between the low and the high values of the active box, those of its empty
/// voxels too: that of the greatest variance between the two (N. Otsu, 1979, eq. 18), of 1024.
double otsu_threshold(const Field& density);

/// The scene's surfaces by ascending values; if it has none, one at 0 for a level set, else at
/// otsu_threshold. They are in the grid's own values, which are distances in a level set. Throws
/// Error(usage) if a level set does not store that distance.
std::vector<ShownSurface> resolved_isovalue(const Scene& scene, const Field& density);

/// Converts a resolved isovalue to the field's values, which are scaled, and in a level set are not
/// distances (Field::half_width).
double field_isovalue(double isovalue, const Field& density);

/// Throws Error(usage) if the scene has an option that does not work with a function of the
/// gradient, which its transfer function is.
void check_gradient_rules(const Scene& scene);

}  // namespace psivox
