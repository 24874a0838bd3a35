#pragma once

#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// The field with voxels twice as wide, so many times: each has the mean of the eight in its place,
/// so that a linear field stays the same. Ranges and percentiles stay those of the field. Its
/// values are in memory; those of a field whose values stay in the file are read a few at a time.
/// `centering`: by which values will be placed, after this.
Field coarse_field(const Field& field, int times, Centering centering);

}  // namespace psivox
