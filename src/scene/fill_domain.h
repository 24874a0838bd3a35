#pragma once

#include "psivox/field.h"

namespace psivox {

/// Adds tiles of value 0 wherever a field's domain has neither leaf nor tile, so that a function of
/// the stored values is one of all values. Throws Error(memory) where that takes more than 2^22.
void fill_domain(Field& field);

/// The same in the blocks of 8^3 voxels next to leaves and tiles only: those that trilinear
/// interpolation mixes with what is stored.
void fill_surroundings(Field& field);

}  // namespace psivox
