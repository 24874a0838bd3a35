#pragma once

#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// The scene's isovalue, else 0 for a level set, else the middle of the active values. It is in the
/// grid's own values, which are distances in a level set. Throws Error(usage) if a level set does
/// not store that distance.
double resolved_isovalue(const Scene& scene, const Field& density);

/// Converts a resolved isovalue to the field's values, which in a level set are not distances
/// (Field::half_width).
double field_isovalue(double isovalue, const Field& density);

}  // namespace psivox
