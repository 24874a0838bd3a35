#include "view/controls.h"

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

using Command = void (*)(Viewer&, const Event&);

void look_along(Viewer& viewer, Axis axis, const Event& event) {
  viewer.navigation().look(axis, with_control(event) || with_shift(event));
}

/// The key that does the same.
int usual_key(const Event& event) {
  static const std::map<int, int> usual = {{GLFW_KEY_KP_1, GLFW_KEY_1},
                                           {GLFW_KEY_KP_3, GLFW_KEY_3},
                                           {GLFW_KEY_KP_7, GLFW_KEY_7},
                                           {GLFW_KEY_KP_5, GLFW_KEY_O},
                                           {GLFW_KEY_F1, GLFW_KEY_H}};
  if (event.code == GLFW_KEY_SLASH && with_shift(event)) return GLFW_KEY_H;
  const auto found = usual.find(event.code);
  return found == usual.end() ? event.code : found->second;
}

/// What a key that is pressed does; null: nothing. key_help describes it to the user.
Command command_of(int key) {
  static const std::map<int, Command> commands = {
      {GLFW_KEY_F, [](Viewer& viewer, const Event&) { viewer.navigation().frame_all(); }},
      {GLFW_KEY_1, [](Viewer& viewer, const Event& e) { look_along(viewer, Axis::front, e); }},
      {GLFW_KEY_3, [](Viewer& viewer, const Event& e) { look_along(viewer, Axis::right, e); }},
      {GLFW_KEY_7, [](Viewer& viewer, const Event& e) { look_along(viewer, Axis::top, e); }},
      {GLFW_KEY_O, [](Viewer& viewer, const Event&) { viewer.navigation().toggle_projection(); }},
      {GLFW_KEY_R, [](Viewer& viewer, const Event&) { viewer.reload(); }},
      {GLFW_KEY_S,
       [](Viewer& viewer, const Event& event) {
         if (with_control(event))
           viewer.attempt([&] { viewer.save_picture(viewer.panels().picture_path); });
       }},
      {GLFW_KEY_C,
       [](Viewer& viewer, const Event& event) {
         if (with_control(event)) viewer.attempt([&] { viewer.copy_command_line(); });
       }},
      {GLFW_KEY_T, [](Viewer& viewer, const Event&) { viewer.panels().transfer ^= true; }},
      {GLFW_KEY_TAB, [](Viewer& viewer, const Event&) { viewer.panels().scene ^= true; }},
      {GLFW_KEY_H, [](Viewer& viewer, const Event&) { viewer.panels().help ^= true; }},
      {GLFW_KEY_X,
       [](Viewer& viewer, const Event&) {
         const int next = (int(viewer.display().comparison) + 1) % 3;
         viewer.compare(Comparison(next), viewer.other());
       }},
      {GLFW_KEY_SPACE, [](Viewer& viewer, const Event&) { viewer.sequence().toggle_playing(); }},
      {GLFW_KEY_RIGHT,
       [](Viewer& viewer, const Event&) { viewer.sequence().go_to(viewer.sequence().next()); }},
      {GLFW_KEY_LEFT,
       [](Viewer& viewer, const Event&) { viewer.sequence().go_to(viewer.sequence().previous()); }},
      {GLFW_KEY_ESCAPE, [](Viewer& viewer, const Event&) { viewer.panels().help = false; }},
  };
  const auto found = commands.find(key);
  return found == commands.end() ? nullptr : found->second;
}

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

void Controls::key(const Event& event) {
  if (steer(event) || !event.down || viewer_.gui().takes_keys()) return;
  if (const Command command = command_of(usual_key(event))) command(viewer_, event);
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
