// The commands of keys, panels and drops.

#include <algorithm>
#include <set>

#include "app/command_text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/camera_file.h"
#include "view/viewer.h"

namespace psivox::view {
namespace {

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

void Viewer::open(const std::vector<std::string>& inputs) {
  messages_.attempt([&] {
    Sequence sequence = Sequence::of(inputs);
    if (!fallback_) fallback_ = now_;
    sequence.rate = now_.sequence.rate;
    now_.sequence = std::move(sequence);
    now_.inputs = inputs;
    now_.look.start_again(now_.scene);
    now_.scene = for_another_file(now_.scene);
    now_.scene.input = now_.sequence.path();
    panels_.open_path = inputs.front();
    camera_due_ = true;
    volume_.retry();
    redraw(3);
  });
}

void Viewer::set_scene(const Scene& scene) {
  const Scene before = now_.scene;
  const bool moves_camera = !same_camera(this->scene(), scene);
  now_.scene = scene;
  now_.scene.resolution = before.resolution;
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

void Viewer::choose_look(const std::string& name) {
  if (now_.scene.input.empty()) return;
  if (!fallback_) fallback_ = now_;
  now_.look.choose(name, now_.scene);
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

void Viewer::edit_transfer_function() { editor_.draw(now_.scene, *volume(), panels_.transfer); }

void Viewer::photograph(const std::string& path) {
  photograph_ = path;
  draw(0.01);
}

}  // namespace psivox::view
