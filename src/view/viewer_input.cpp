// What hands do to the viewer.

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "view/viewer.h"

namespace psivox::view {
namespace {

constexpr double double_click_s = 0.35;
// [pixels, where text has its usual size]
constexpr double divider_reach = 6, double_click_reach = 4;

/// Directions of flight by key, along right, up and forward.
bool flight(int key, glm::dvec3& direction) {
  switch (key) {
    case GLFW_KEY_W:
      direction = {0, 0, 1};
      return true;
    case GLFW_KEY_S:
      direction = {0, 0, -1};
      return true;
    case GLFW_KEY_A:
      direction = {-1, 0, 0};
      return true;
    case GLFW_KEY_D:
      direction = {1, 0, 0};
      return true;
    case GLFW_KEY_E:
      direction = {0, 1, 0};
      return true;
    case GLFW_KEY_Q:
      direction = {0, -1, 0};
      return true;
    default:
      return false;
  }
}

}  // namespace

void Viewer::handle(const Event& event) {
  gui_.feed(event);
  using Kind = Event::Kind;
  switch (event.kind) {
    case Kind::move:
      handle_move(event);
      break;
    case Kind::button:
      handle_button(event);
      break;
    case Kind::wheel:
      if (!gui_.takes_pointer()) navigation_.dolly(event.place.y);
      break;
    case Kind::key:
      handle_key(event);
      break;
    case Kind::text:
    case Kind::scale:
    case Kind::refresh:  // every event has the window drawn
      break;
    case Kind::drop:
      if (!event.files.empty()) attempt([&] { open(event.files.front()); });
      break;
    case Kind::close:
      closed_ = true;
      break;
  }
}

void Viewer::handle_button(const Event& event) {
  pointer_ = event.place;
  if (!event.down) {
    if (event.code == dragging_) dragging_ = -1;
    dragging_divider_ = false;
    return;
  }
  if (gui_.takes_pointer() || dragging_ >= 0) return;
  const double divider = look_.divider * window_.size().x;
  if (event.code == GLFW_MOUSE_BUTTON_LEFT && look_.comparison == Comparison::wipe &&
      std::abs(event.place.x - divider) < divider_reach * gui_.scale()) {
    dragging_divider_ = true;
    return;
  }
  dragging_ = event.code;
  if (event.code != GLFW_MOUSE_BUTTON_LEFT) return;
  const auto now = Clock::now();
  const glm::dvec2 apart = event.place - clicked_at_;
  const bool near = std::hypot(apart.x, apart.y) < double_click_reach * gui_.scale();
  if (near && now - clicked_ < std::chrono::duration<double>(double_click_s))
    maker_.pick(glm::floor(event.place) + 0.5);
  clicked_ = now;
  clicked_at_ = event.place;
}

void Viewer::handle_move(const Event& event) {
  const glm::dvec2 by = event.place - pointer_;
  pointer_ = event.place;
  if (dragging_divider_) {
    look_.divider = std::clamp(event.place.x / std::max(window_.size().x, 1), 0.0, 1.0);
  } else if (dragging_ == GLFW_MOUSE_BUTTON_LEFT) {
    navigation_.orbit(by);
  } else if (dragging_ == GLFW_MOUSE_BUTTON_MIDDLE) {
    navigation_.pan(by);
  } else if (dragging_ == GLFW_MOUSE_BUTTON_RIGHT) {
    navigation_.dolly(-0.05 * by.y / gui_.scale());
  }
}

void Viewer::handle_key(const Event& event) {
  glm::dvec3 direction;
  if (flight(event.code, direction)) {
    // a key that comes up always ends its flight
    if (!event.down || gui_.takes_keys() || (event.modifiers & GLFW_MOD_CONTROL)) {
      for (int i = 0; i < 3; ++i)
        if (flying_[i] * direction[i] > 0) flying_[i] = 0;
    } else {
      for (int i = 0; i < 3; ++i)
        if (direction[i] != 0) flying_[i] = direction[i];
    }
    if (event.code != GLFW_KEY_S || !(event.modifiers & GLFW_MOD_CONTROL)) return;
  }
  if (!event.down || gui_.takes_keys()) return;
  const bool control = event.modifiers & GLFW_MOD_CONTROL;
  const bool shift = event.modifiers & GLFW_MOD_SHIFT;
  switch (event.code) {
    case GLFW_KEY_F:
      navigation_.frame_all();
      break;
    case GLFW_KEY_1:
    case GLFW_KEY_KP_1:
      navigation_.look(Axis::front, control || shift);
      break;
    case GLFW_KEY_3:
    case GLFW_KEY_KP_3:
      navigation_.look(Axis::right, control || shift);
      break;
    case GLFW_KEY_7:
    case GLFW_KEY_KP_7:
      navigation_.look(Axis::top, control || shift);
      break;
    case GLFW_KEY_O:
    case GLFW_KEY_KP_5:
      navigation_.toggle_projection();
      break;
    case GLFW_KEY_R:
      reload();
      break;
    case GLFW_KEY_S:
      if (control) attempt([&] { save_picture(picture_path_); });
      break;
    case GLFW_KEY_C:
      if (control) attempt([&] { copy_command_line(); });
      break;
    case GLFW_KEY_T:
      show_transfer_ = !show_transfer_;
      break;
    case GLFW_KEY_TAB:
      show_panels_ = !show_panels_;
      break;
    case GLFW_KEY_H:
    case GLFW_KEY_F1:
      show_help_ = !show_help_;
      break;
    case GLFW_KEY_SLASH:
      if (shift) show_help_ = !show_help_;
      break;
    case GLFW_KEY_X: {
      const int next = (static_cast<int>(look_.comparison) + 1) % 3;
      compare(static_cast<Comparison>(next), other_);
      break;
    }
    case GLFW_KEY_SPACE:
      sequence_.playing = !sequence_.empty() && !sequence_.playing;
      break;
    case GLFW_KEY_RIGHT:
      sequence_.go_to(sequence_.next());
      break;
    case GLFW_KEY_LEFT:
      sequence_.go_to(sequence_.previous());
      break;
    case GLFW_KEY_ESCAPE:
      show_help_ = false;
      break;
    default:
      break;
  }
}

void Viewer::fly(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - flown_).count();
  flown_ = now;
  if (flying_ == glm::dvec3(0)) return;
  navigation_.fly(flying_, std::min(seconds, 0.1));
  frames_due_ = std::max(frames_due_, 1);
}

}  // namespace psivox::view
