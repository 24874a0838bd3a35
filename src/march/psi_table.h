#pragma once

#include <glm/vec4.hpp>
#include <vector>

namespace psivox {

/// The table that shaders/integrators/psi_table.glsl reads: an entry for each cell, the front end's
/// place major, with the values at (front, back) = (i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1).
std::vector<glm::vec4> make_psi_table();

}  // namespace psivox
