#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "psivox/field.h"

namespace psivox {

/// Maps a stored value; called from several threads.
using VoxelMap = std::function<glm::vec3(const glm::vec3& value)>;

/// The field with every stored value mapped, to `channels` components; values that are not stored
/// stay 0. A scalar is in the first component, before and after.
Field map_field(const Field& field, int channels, const VoxelMap& map);

}  // namespace psivox
