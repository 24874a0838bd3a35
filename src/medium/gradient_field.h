#pragma once

#include "psivox/field.h"

namespace psivox {

/// Magnitude of the gradient of a scalar field at its voxels [value/world unit], as a field of the
/// same domain and transform: central differences over the two neighbours along each index axis,
/// turned into the world's by the inverse transpose of the transform. For smooth data the error is
/// a sixth of the third derivatives. A leaf is stored only if some voxel's gradient is not 0.
/// Throws Error(memory) beyond 2^24 of them.
Field gradient_of_voxels(const Field& field);

/// A field with the given gradients, in which every place with a gradient is stored in blocks of
/// 8^3 voxels. Tiles are split until each lies in one block or has no gradient. If `with_zeros`,
/// blocks that have a gradient but store nothing become tiles of 0. Tiles outside the domain are
/// left out.
/// Throws Error(memory) beyond 2^24 tiles.
Field told_by_blocks(const Field& field, const Field& gradient, bool with_zeros);

}  // namespace psivox
