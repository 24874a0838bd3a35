#pragma once

#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// What a coarse voxel has of the eight in its place: their mean, or one of them, so that all
/// values stay as frequent as they are.
enum class CoarseValue { mean, sample };

/// The field with voxels twice as wide, so many times: each has a value of the eight in its place.
/// With means a linear field stays the same. Ranges and percentiles stay the same, too. The result
/// is in memory; if the field's values stay in its file, they are read a few at a time.
/// `centering`: by which values will be placed, after this.
Field coarse_field(const Field& field, int times, Centering centering, CoarseValue value = {});

}  // namespace psivox
