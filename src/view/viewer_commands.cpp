// Keys and the pointer, and the commands of keys, panels and drops.

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "app/command_text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "scene/camera_file.h"
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

void save_picture(Viewer& viewer, const Event&) {
  viewer.messages().attempt([&] { viewer.save_picture(viewer.panels().picture_path); });
}

void copy_command_line(Viewer& viewer, const Event&) {
  viewer.messages().attempt([&] { viewer.copy_command_line(); });
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

bool same_camera(const Scene& a, const Scene& b) {
  return std::ranges::all_of(parameters(), [&](const Parameter& p) {
    return p.group != ParameterGroup::camera || has_same(a, b, p);
  });
}

/// The scene without names of grids, values and places, which belong to its file.
Scene for_another_file(Scene scene) {
  static const std::set<std::string> of_file{
      "grid", "camera-position", "camera-target", "ortho-width", "extinction", "range", "isovalue"};
  for (const Parameter& p : parameters())
    if (names_side_grid(p) || of_file.contains(p.name)) set_default(scene, p);
  return scene;
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
       look,
       Control::either},
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
      {"Ctrl+Z",
       "undo a change of the scene",
       {GLFW_KEY_Z},
       [](Viewer& v, auto&) { v.undo(); },
       Control::held},
      {"Ctrl+S", "save the picture", {GLFW_KEY_S}, save_picture, Control::held},
      {"Ctrl+C", "copy as command line", {GLFW_KEY_C}, copy_command_line, Control::held},
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
  const Control unwanted = with_control(event) ? Control::free : Control::held;
  for (const Command& command : commands())
    if (std::ranges::count(command.codes, event.code) && command.control != unwanted)
      return command.act(viewer_, event);
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
  else if (!viewer_.gui().takes_pointer())
    viewer_.probe(glm::floor(event.place) + 0.5);
}

bool Controls::fly(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - flown_).count();
  flown_ = now;
  if (!flying()) return false;
  viewer_.navigation().fly(speed_, std::min(seconds, 0.1));
  return true;
}

void Viewer::open(const std::vector<std::string>& inputs) {
  const std::string& first = inputs.front();
  const bool of_scene =
      inputs.size() == 1 && (first.ends_with(".json") || has_picture_extension(first));
  messages_.attempt([&] { of_scene ? open_scene(first) : open_files(inputs); });
}

void Viewer::open_scene(const std::string& path) {
  Scene scene = read_scene_file(path).scene;
  if (scene.input.empty()) scene.input = now_.scene.input;
  Opened next{scene, LookChoice(scene), Sequence::of({scene.input}), {scene.input}};
  next.look.ask(next.look.start(), next.scene, /*camera_too=*/true);
  start(std::move(next), path);
}

void Viewer::open_files(const std::vector<std::string>& inputs) {
  Opened next{now_.scene, now_.look, Sequence::of(inputs), inputs};
  next.look.ask(next.look.start(), next.scene, /*camera_too=*/true);
  next.scene = for_another_file(next.scene);
  start(std::move(next), inputs.front());
}

void Viewer::start(Opened next, const std::string& name) {
  if (!fallback_) fallback_ = now_;
  history_.clear();  // of another file
  next.sequence.rate = now_.sequence.rate;
  now_ = std::move(next);
  now_.scene.input = now_.sequence.path();
  panels_.open_path = name;
  camera_due_ = true;
  volume_.retry();
  redraw(3);
}

void Viewer::remember() {
  constexpr std::size_t most = 100;
  if (std::exchange(changing_, gui_.editing()) && !history_.empty()) return;
  history_.emplace_back(now_.scene, now_.look);
  if (history_.size() > most) history_.erase(history_.begin());
}

void Viewer::undo() {
  if (history_.empty()) return messages_.say("nothing to undo");
  std::tie(now_.scene, now_.look) = history_.back();
  history_.pop_back();
  changing_ = false;
  fallback_.reset();
  volume_.retry();
  messages_.say("undone");
  redraw(3);
}

void Viewer::set_scene(const Scene& scene) {
  const Scene before = now_.scene;
  remember();
  const bool moves_camera = !same_camera(this->scene(), scene);
  now_.scene = scene;
  now_.scene.resolution = before.resolution;
  if (scene.colormap && scene.colormap != before.colormap && !asks_for_look(before)) {
    // what render chooses for the map, in place of what was chosen for the last one
    now_.look.ask(now_.look.start(), now_.scene);
    volume_.retry();
  } else if (has_bright_background(scene) != has_bright_background(before) &&
             !asks_for_look(before)) {
    now_.look.ask(now_.look.name(), now_.scene);
    volume_.retry();
  }
  redraw(3);
  // the default camera faces the slice
  if (!volume() || (!moves_camera && navigation_.moved())) return;
  try {
    navigation_.reset(this->scene(), *volume()->subject);
  } catch (const Error& e) {
    now_.scene = before;
    messages_.error(e.what());
  }
}

void Viewer::probe(const glm::dvec2& pixel) {
  if (pictures_.complete()) maker_.probe(pixel);
}

void Viewer::choose_look(const std::string& name) {
  if (now_.scene.input.empty()) return;
  if (!fallback_) fallback_ = now_;
  remember();
  now_.scene = without_look(now_.scene);
  now_.look.ask(name, now_.scene);
  if (!asks_for_look(now_.scene)) messages_.say("look " + name);
  volume_.retry();
  redraw(3);
}

void Viewer::compare(Comparison comparison, const std::optional<Scene>& other) {
  settings_.comparison = comparison;
  if (comparison == Comparison::none)
    other_.reset();
  else
    other_ = other ? other : coarser(now_.scene);
  redraw(3);
}

void Viewer::show(ShownLayer layer) {
  if (layer == layer_) return;
  layer_ = layer;
  pictures_.layer_range = {};
  ++pictures_.wished;  // what is complete is of the other layer
  posted_.clear();
  redraw(3);
}

void Viewer::reload() {
  volume_.reload();
  maker_.reload_shaders();
  redraw(3);
}

Scene Viewer::kept_scene() {
  Scene kept = scene();
  if (!panels_.picture_size.empty()) set_parameter(kept, "resolution", panels_.picture_size);
  if (const auto name = editor_.keep(kept)) {
    now_.scene.transfer_function = *name;
    messages_.say("the transfer function is in " + *name);
  }
  return kept;
}

std::string Viewer::copy_command_line() {
  const std::string line = render_command_line(kept_scene(), panels_.picture_path);
  window_.set_clipboard(line);
  messages_.say("copied: " + line);
  return line;
}

void Viewer::save_scene(const std::string& path) {
  if (is_camera_file(path) && volume()) {
    const Subject& subject = *volume()->subject;
    write_camera(path, make_camera(scene(), subject), z_is_up(scene(), subject));
  } else {
    write_text(path, to_json(kept_scene()));
  }
  messages_.say("saved " + path);
}

void Viewer::save_picture(const std::string& path) {
  if (!options_.render || saving()) return;
  std::vector<std::string> arguments = render_arguments(kept_scene(), path);
  arguments.insert(arguments.begin(), "--quiet");
  saved_path_ = path;
  saving_ = std::async(std::launch::async, options_.render, std::move(arguments));
}

void Viewer::edit_transfer_function() {
  Scene edited = now_.scene;
  const bool goes_on = changing_;
  editor_.draw(edited, *volume(), panels_.transfer, goes_on);
  if (has_same(edited, now_.scene, *find_parameter("transfer-function")) &&
      edited.extinction == now_.scene.extinction)
    return;
  remember();
  now_.scene = std::move(edited);
}

void Viewer::photograph(const std::string& path) {
  photograph_ = path;
  draw(0.01);
}

}  // namespace psivox::view
