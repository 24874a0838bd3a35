#pragma once

#include <string_view>

namespace psivox {

/// Whether a GL driver of this GL_RENDERER draws with the processor.
inline bool is_software(std::string_view renderer) {
  return renderer.find("llvmpipe") != std::string_view::npos;
}

}  // namespace psivox
