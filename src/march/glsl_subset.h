#pragma once

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

/// C++'s side of the subset that shaders/ is written in: the names that binding.glsl defines for
/// GLSL, here in double. Structs that take the shader's functions as members live in this
/// namespace.
namespace psivox::glsl {

using glm::abs;
using glm::clamp;
using glm::dot;
using glm::floor;
using glm::max;
using glm::min;
using glm::mix;
using std::exp;
using std::expm1;
using std::log1p;
using std::pow;
using std::sqrt;

using real = double;
using real2 = glm::dvec2;
using real3 = glm::dvec3;
using real4 = glm::dvec4;
using int3 = glm::ivec3;
using uint = std::uint32_t;
using uint4 = glm::uvec4;

}  // namespace psivox::glsl
