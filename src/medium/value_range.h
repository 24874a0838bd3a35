#pragma once

#include <glm/vec2.hpp>

#include "psivox/field.h"

namespace psivox {

/// Least and greatest value of a scalar field, including the 0 where nothing is stored.
glm::dvec2 stored_range(const Field& field);

/// The smallest active value that at least `percent` of the active values do not exceed, as found
/// by reading; for other fields, of the active box's voxels.
double active_percentile(const Field& field, double percent);

/// Least and greatest active value, as found by reading; for other fields, those of the active box.
glm::dvec2 active_range(const Field& field);

}  // namespace psivox
