#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <vector>

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

void look(Viewer& viewer, const Event& event) {
  static const std::map<int, Axis> axes = {{GLFW_KEY_1, Axis::front}, {GLFW_KEY_KP_1, Axis::front},
                                           {GLFW_KEY_3, Axis::right}, {GLFW_KEY_KP_3, Axis::right},
                                           {GLFW_KEY_7, Axis::top},   {GLFW_KEY_KP_7, Axis::top}};
  viewer.navigation().look(axes.at(event.code), with_control(event) || with_shift(event));
}

void go_on(Viewer& viewer, const Event& event) {
  Sequence& sequence = viewer.sequence();
  sequence.go_to(event.code == GLFW_KEY_RIGHT ? sequence.next() : sequence.previous());
}

void compare_otherwise(Viewer& viewer, const Event&) {
  viewer.compare(Comparison((int(viewer.display().comparison) + 1) % 3), viewer.other());
}

void save_picture(Viewer& viewer, const Event& event) {
  if (!with_control(event)) return;
  viewer.messages().attempt([&] { viewer.save_picture(viewer.panels().picture_path); });
}

void copy_command_line(Viewer& viewer, const Event& event) {
  if (with_control(event)) viewer.messages().attempt([&] { viewer.copy_command_line(); });
}

template <bool Panels::*panel>
void toggle(Viewer& viewer, const Event&) {
  viewer.panels().*panel ^= true;
}

void help(Viewer& viewer, const Event& event) {
  if (event.code == GLFW_KEY_SLASH && !with_shift(event)) return;
  bool& shown = viewer.panels().help;
  shown = !shown && event.code != GLFW_KEY_ESCAPE;
}

}  // namespace

const std::vector<Command>& commands() {
  static const std::vector<Command> table = {
      {"left drag", "orbit around the pivot"},
      {"middle drag", "pan"},
      {"wheel, right drag", "dolly towards the pivot"},
      {"double click", "pivot on what is under the pointer"},
      {"W A S D, E Q", "fly forward, left, back, right, up, down"},
      {"F", "frame all", {GLFW_KEY_F}, [](Viewer& v, auto&) { v.navigation().frame_all(); }},
      {"1 3 7",
       "view from the front, the right, above; with Shift or Ctrl from the other side",
       {GLFW_KEY_1, GLFW_KEY_KP_1, GLFW_KEY_3, GLFW_KEY_KP_3, GLFW_KEY_7, GLFW_KEY_KP_7},
       look},
      {"O",
       "orthographic or perspective",
       {GLFW_KEY_O, GLFW_KEY_KP_5},
       [](Viewer& v, auto&) { v.navigation().toggle_projection(); }},
      {"T", "transfer function", {GLFW_KEY_T}, toggle<&Panels::transfer>},
      {"X", "one picture, two with a divider, signed difference", {GLFW_KEY_X}, compare_otherwise},
      {"Space",
       "play or pause a sequence",
       {GLFW_KEY_SPACE},
       [](Viewer& v, auto&) { v.sequence().toggle_playing(); }},
      {"Left, Right", "frame before, frame after", {GLFW_KEY_LEFT, GLFW_KEY_RIGHT}, go_on},
      {"R", "read file and shaders again", {GLFW_KEY_R}, [](Viewer& v, auto&) { v.reload(); }},
      {"Ctrl+S", "save the picture", {GLFW_KEY_S}, save_picture},
      {"Ctrl+C", "copy as command line", {GLFW_KEY_C}, copy_command_line},
      {"Tab", "panel", {GLFW_KEY_TAB}, toggle<&Panels::scene>},
      {"? or H", "this help", {GLFW_KEY_SLASH, GLFW_KEY_H, GLFW_KEY_F1, GLFW_KEY_ESCAPE}, help},
  };
  return table;
}

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

void Controls::key(const Event& event) {
  if (steer(event) || !event.down || viewer_.gui().takes_keys()) return;
  for (const Command& command : commands())
    if (std::ranges::count(command.codes, event.code)) return command.act(viewer_, event);
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
