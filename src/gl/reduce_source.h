#pragma once

#include "gl/shader_source.h"

namespace psivox::gl {

/// A shader without what its constants exclude: branches on them, what follows a `return`,
/// functions that main does not reach, conditional parts and comments. Some compilers inline all of
/// it before they fold constants, which takes them minutes (docs/gpu.md). The lines that remain
/// keep their places.
///
/// Constants are `const int` and `const bool` with known values, and rows of DERIVED. A function
/// that holds lines of the preprocessor stays whole, and so does a text with #ifdef or the like.
ShaderSource reduced(const ShaderSource& source);

}  // namespace psivox::gl
