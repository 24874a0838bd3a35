#pragma once

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace psivox::view {

/// An action of the user on the window, or of a test in its place. Codes are GLFW's. Places are
/// pixels of the framebuffer from the top left.
struct Event {
  enum class Kind { move, button, wheel, key, text, drop, close, scale, refresh };
  Kind kind = Kind::move;
  glm::dvec2 place{
      0};        ///< of the pointer; of a wheel: its notches; x of a scale: of text from now on
  int code = 0;  ///< button, key or character
  bool down = false;
  int modifiers = 0;
  std::vector<std::string> files{};  ///< dropped
};

}  // namespace psivox::view
