#pragma once

#include "psivox/field.h"

namespace psivox {

/// Magnitude of the gradient of a scalar field at its voxels [value/world unit], as a field of the
/// same domain and transform: central differences over the two neighbours along each index axis,
/// turned into the world's by the inverse transpose of the transform. Of smooth data off by a sixth
/// of its third derivatives. Leaves only where some voxel's is not 0. Throws Error(memory) beyond
/// 2^24 of them.
Field gradient_of_voxels(const Field& field);

/// The field, whose gradients are given, so that what it has next to a gradient is told by blocks
/// of 8^3 voxels: tiles are split until each either lies in one block or has no gradient, and,
/// `with_zeros`, blocks that have a gradient and store nothing become tiles of 0. Tiles outside of
/// the domain are left out.
/// Throws Error(memory) beyond 2^24 tiles.
Field told_by_blocks(const Field& field, const Field& gradient, bool with_zeros);

}  // namespace psivox
