#pragma once

#include <chrono>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "view/events.h"

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

}  // namespace psivox::view
