#pragma once

#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// The scene's isovalue, or the middle of the active values, or 0 of a level set: in the grid's own
/// values, of a level set distances. Throws Error(usage) where a level set stores no such distance.
double resolved_isovalue(const Scene& scene, const Field& density);

/// The same in the field's values, which of a level set are not distances (Field::half_width).
double field_isovalue(double isovalue, const Field& density);

}  // namespace psivox
