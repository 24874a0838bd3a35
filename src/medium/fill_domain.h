#pragma once

#include "psivox/field.h"

namespace psivox {

/// Adds tiles of value 0 wherever a field's domain has neither leaf nor tile, so that a function of
/// the stored values applies to all values. Throws Error(memory) if that takes more than 2^22
/// tiles.
void fill_domain(Field& field);

/// Adds tiles of value 0 only in the blocks of 8^3 voxels next to leaves and tiles, whose values
/// trilinear interpolation mixes with stored ones.
void fill_surroundings(Field& field);

}  // namespace psivox
