#pragma once

#include <string>
#include <vector>

#include "gl/webgl_march.h"

namespace psivox {

/// The texts of a texture's elements, from which `load_texture` in march.js makes its entries: of
/// each of its numbers one, and of codes two.
std::vector<std::string> packed(const gl::WebTexture& texture);

}  // namespace psivox
