#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

namespace psivox {

/// [x, y, z].
template <typename T>
nlohmann::ordered_json vector_json(const glm::vec<3, T>& v) {
  return {v.x, v.y, v.z};
}

}  // namespace psivox
