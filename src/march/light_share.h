#pragma once

#include <functional>
#include <glm/common.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "psivox/field.h"

namespace psivox {

/// This process's share of a medium that several light together; by default it has all.
struct LightShare {
  /// Voxels that none but this process has.
  Box voxels{glm::ivec3(std::numeric_limits<int>::min()),
             glm::ivec3(std::numeric_limits<int>::max())};
  /// The leaves of the whole density, without values; null: those of the medium's.
  std::shared_ptr<const Field> whole{};
  /// What each process gives, by its number; unset: there are no others.
  std::function<std::vector<std::string>(const std::string& bytes)> gather{};

  bool has(const glm::ivec3& voxel) const {
    return voxel == glm::clamp(voxel, voxels.min, voxels.max);
  }
};

}  // namespace psivox
