#pragma once

#include <glm/vec2.hpp>

#include "psivox/field.h"

namespace psivox {

/// Least and greatest of all that a scalar field has, the 0 where nothing is stored included.
glm::dvec2 stored_range(const Field& field);

/// Least and greatest active value, as reading found them; of a field made otherwise those of the
/// active box.
glm::dvec2 active_range(const Field& field);

}  // namespace psivox
