#pragma once

#include <functional>
#include <glm/vec3.hpp>

#include "psivox/field.h"

namespace psivox {

/// What a stored value becomes; called from several threads.
using VoxelMap = std::function<glm::vec3(const glm::vec3& value)>;

/// The field with every stored value mapped, to `channels` components; what is not stored stays 0.
/// A scalar's value is in the first component, here and there.
Field map_field(const Field& field, int channels, const VoxelMap& map);

}  // namespace psivox
