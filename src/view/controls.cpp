#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <map>

#include "view/viewer.h"

namespace psivox::view {
namespace {

constexpr double double_click_s = 0.35;
// [pixels, where text has its usual size]
constexpr double divider_reach = 6, double_click_reach = 4;

bool with_control(const Event& event) { return event.modifiers & GLFW_MOD_CONTROL; }
bool with_shift(const Event& event) { return event.modifiers & GLFW_MOD_SHIFT; }

/// The direction in which a key flies, along right, up and forward; 0: none.
glm::dvec3 flight_of(int key) {
  static const std::map<int, glm::dvec3> directions = {
      {GLFW_KEY_W, {0, 0, 1}}, {GLFW_KEY_S, {0, 0, -1}}, {GLFW_KEY_A, {-1, 0, 0}},
      {GLFW_KEY_D, {1, 0, 0}}, {GLFW_KEY_E, {0, 1, 0}},  {GLFW_KEY_Q, {0, -1, 0}},
  };
  const auto found = directions.find(key);
  return found == directions.end() ? glm::dvec3(0) : found->second;
}

}  // namespace

bool Controls::steer(const Event& event) {
  const glm::dvec3 direction = flight_of(event.code);
  if (direction == glm::dvec3(0)) return false;
  // a key that comes up always ends its flight
  const bool go = event.down && !viewer_.gui().takes_keys() && !with_control(event);
  for (int i = 0; i < 3; ++i) {
    const double along = direction[i];
    if (go && along != 0) speed_[i] = along;
    if (!go && speed_[i] * along > 0) speed_[i] = 0;
  }
  return !(event.code == GLFW_KEY_S && with_control(event));
}

void Controls::look(Axis axis, const Event& event) {
  viewer_.navigation().look(axis, with_control(event) || with_shift(event));
}

// key_help describes the commands to the user.
void Controls::command(const Event& event) {
  Panels& panels = viewer_.panels();
  Sequence& sequence = viewer_.sequence();
  switch (event.code) {
    case GLFW_KEY_F:
      return viewer_.navigation().frame_all();
    case GLFW_KEY_1:
    case GLFW_KEY_KP_1:
      return look(Axis::front, event);
    case GLFW_KEY_3:
    case GLFW_KEY_KP_3:
      return look(Axis::right, event);
    case GLFW_KEY_7:
    case GLFW_KEY_KP_7:
      return look(Axis::top, event);
    case GLFW_KEY_O:
    case GLFW_KEY_KP_5:
      return viewer_.navigation().toggle_projection();
    case GLFW_KEY_R:
      return viewer_.reload();
    case GLFW_KEY_S:
      if (!with_control(event)) return;
      return viewer_.attempt([&] { viewer_.save_picture(panels.picture_path); });
    case GLFW_KEY_C:
      if (!with_control(event)) return;
      return viewer_.attempt([&] { viewer_.copy_command_line(); });
    case GLFW_KEY_X:
      return viewer_.compare(Comparison((int(viewer_.display().comparison) + 1) % 3),
                             viewer_.other());
    case GLFW_KEY_SPACE:
      return sequence.toggle_playing();
    case GLFW_KEY_RIGHT:
      return sequence.go_to(sequence.next());
    case GLFW_KEY_LEFT:
      return sequence.go_to(sequence.previous());
    case GLFW_KEY_T:
      panels.transfer ^= true;
      return;
    case GLFW_KEY_TAB:
      panels.scene ^= true;
      return;
    case GLFW_KEY_SLASH:
      if (!with_shift(event)) return;
      [[fallthrough]];
    case GLFW_KEY_H:
    case GLFW_KEY_F1:
      panels.help ^= true;
      return;
    case GLFW_KEY_ESCAPE:
      panels.help = false;
  }
}

void Controls::key(const Event& event) {
  if (!steer(event) && event.down && !viewer_.gui().takes_keys()) command(event);
}

bool Controls::double_click(const glm::dvec2& place) {
  const auto now = Clock::now();
  const glm::dvec2 apart = place - clicked_at_;
  const bool near = std::hypot(apart.x, apart.y) < double_click_reach * viewer_.gui().scale();
  const bool soon = now - clicked_ < std::chrono::duration<double>(double_click_s);
  clicked_ = now;
  clicked_at_ = place;
  return near && soon;
}

void Controls::button(const Event& event) {
  pointer_ = event.place;
  if (!event.down) {
    if (event.code == button_) button_ = -1;
    dragging_divider_ = false;
    return;
  }
  const Gui& gui = viewer_.gui();
  if (gui.takes_pointer() || button_ >= 0) return;
  const DisplaySettings& look = viewer_.display();
  const double divider = look.divider * viewer_.window().size().x;
  if (event.code == GLFW_MOUSE_BUTTON_LEFT && look.comparison == Comparison::wipe &&
      std::abs(event.place.x - divider) < divider_reach * gui.scale()) {
    dragging_divider_ = true;
    return;
  }
  button_ = event.code;
  if (event.code == GLFW_MOUSE_BUTTON_LEFT && double_click(event.place))
    viewer_.pick(glm::floor(event.place) + 0.5);
}

void Controls::move(const Event& event) {
  const glm::dvec2 by = event.place - pointer_;
  pointer_ = event.place;
  Navigation& navigation = viewer_.navigation();
  if (dragging_divider_)
    viewer_.display().divider =
        std::clamp(event.place.x / std::max(viewer_.window().size().x, 1), 0.0, 1.0);
  else if (button_ == GLFW_MOUSE_BUTTON_LEFT)
    navigation.orbit(by);
  else if (button_ == GLFW_MOUSE_BUTTON_MIDDLE)
    navigation.pan(by);
  else if (button_ == GLFW_MOUSE_BUTTON_RIGHT)
    navigation.dolly(-0.05 * by.y / viewer_.gui().scale());
}

bool Controls::fly(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - flown_).count();
  flown_ = now;
  if (!flying()) return false;
  viewer_.navigation().fly(speed_, std::min(seconds, 0.1));
  return true;
}

}  // namespace psivox::view
