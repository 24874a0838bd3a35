#pragma once

#include <chrono>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "view/window.h"

namespace psivox::view {

class Viewer;

/// Keys and the pointer: they move the camera and give commands to the viewer.
class Controls {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Controls(Viewer& viewer) : viewer_(viewer) {}

  void key(const Event& event);
  void button(const Event& event);
  void move(const Event& event);
  /// Moves the camera while keys of flight are down. True if it moved.
  bool fly(Clock::time_point now);

  bool dragging() const { return button_ >= 0; }
  bool flying() const { return speed_ != glm::dvec3(0); }

 private:
  /// True if the key is one of flight and nothing else.
  bool steer(const Event& event);
  /// Whether this is the second click of two.
  bool double_click(const glm::dvec2& place);

  Viewer& viewer_;
  int button_ = -1;  ///< that was pressed over the picture; -1: none
  bool dragging_divider_ = false;
  glm::dvec2 pointer_{0};
  Clock::time_point clicked_{};
  glm::dvec2 clicked_at_{0};
  glm::dvec3 speed_{0};  ///< along right, up and forward
  Clock::time_point flown_{};
};

/// A row of the keyboard help, in the window and in docs/preview.md.
struct KeyHelp {
  const char* keys;
  const char* what;
};

inline constexpr KeyHelp key_help[] = {
    {"left drag", "orbit around the pivot"},
    {"middle drag", "pan"},
    {"wheel, right drag", "dolly towards the pivot"},
    {"double click", "pivot on what is under the pointer"},
    {"W A S D, E Q", "fly forward, left, back, right, up, down"},
    {"F", "frame all"},
    {"1 3 7", "view from the front, the right, above; with Shift or Ctrl from the other side"},
    {"O", "orthographic or perspective"},
    {"T", "transfer function"},
    {"X", "one picture, two with a divider, signed difference"},
    {"Space", "play or pause a sequence"},
    {"Left, Right", "frame before, frame after"},
    {"R", "read file and shaders again"},
    {"Ctrl+S", "save the picture"},
    {"Ctrl+C", "copy as command line"},
    {"Tab", "panel"},
    {"? or H", "this help"},
};

}  // namespace psivox::view
