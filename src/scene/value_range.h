#pragma once

#include <glm/vec2.hpp>

#include "psivox/field.h"

namespace psivox {

/// Least and greatest value of a scalar field, including the 0 where nothing is stored.
glm::dvec2 stored_range(const Field& field);

/// Least and greatest active value, as found by reading; for other fields, those of the active box.
glm::dvec2 active_range(const Field& field);

}  // namespace psivox
