#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "psivox/field.h"
#include "scene/transfer_function.h"

namespace psivox {

/// Maps a stored value; called from several threads.
using VoxelMap = std::function<glm::vec3(const glm::vec3& value)>;

/// The field with every stored value mapped, to `channels` components; values that are not stored
/// stay 0. A scalar is in the first component, before and after.
Field map_field(const Field& field, int channels, const VoxelMap& map);

/// Classification before interpolation: the attenuation of each voxel's value as a scalar field. If
/// 0 has an attenuation, it fills the whole domain. Throws Error(memory).
Field attenuation_of_voxels(const Field& field, const TransferFunction& function);

/// The attenuation of each voxel's value and gradient as a scalar field. `gradient`:
/// gradient_of_voxels(field).
Field attenuation_of_voxels(const Field& field, const Field& gradient,
                            const TransferFunction& function);

/// The colour of each voxel's value as a vec3 field, wherever there is attenuation.
Field color_of_voxels(const Field& field, const TransferFunction& function);

}  // namespace psivox
