#pragma once

#include "gl/shader_source.h"

namespace psivox::gl {

/// The text of a fragment shader in GLSL ES 3.00, which WebGL 2 compiles: its macros replaced, its
/// texture buffers textures of shaders/webgl.glsl, its globals set by main. `textures`: those that
/// there are; others have entries of 0.
std::string webgl_text(const ShaderSource& source, const std::vector<std::string>& textures);

/// The name of a uniform there.
std::string webgl_name(const std::string& name);

}  // namespace psivox::gl
