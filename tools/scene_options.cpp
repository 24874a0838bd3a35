#include "scene_options.h"

#include <algorithm>
#include <utility>

#include "psivox/open.h"
#include "psivox/parameters.h"
#include "psivox/scene_file.h"
#include "psivox/sequence.h"
#include "psivox/vdb.h"

namespace psivox {

bool file_z_is_up(const Scene& scene) {
  if (scene.up_axis != UpAxis::automatic || scene.input.empty()) return scene.up_axis == UpAxis::z;
  const auto files = sequence_files(std::vector{scene.input});
  return !VdbFile(files ? files->begin()->second : scene.input).z_up().empty();
}

void SceneOptions::add_to(CommandLine& line, std::span<const std::string> without) {
  line.add_option("--scene", file_,
                  "read parameters from a .json, or from a picture that psivox wrote; the command "
                  "line overrides them")
      ->type_name("FILE")
      ->group(group_name(ParameterGroup::input));
  line.add_trust();
  line.add_option("--camera", camera_,
                  "camera of a .gltf, .glb or ParaView's .pvcc; :NAME of one of several")
      ->type_name("FILE[:NAME]")
      ->group(group_name(ParameterGroup::camera));
  line.add_parameters(settings_, [&](const Parameter& p) {
    return std::find(without.begin(), without.end(), p.name) == without.end();
  });
}

bool SceneOptions::gives(const std::string& name) const {
  return std::any_of(settings_.begin(), settings_.end(),
                     [&](const Setting& setting) { return setting.name == name; });
}

std::vector<std::string> SceneOptions::notices() const {
  std::vector<std::string> notices;
  for (const Setting& setting : settings_)
    if (std::string notice = color_notice(*find_parameter(setting.name), setting.text);
        !notice.empty())
      notices.push_back(std::move(notice));
  return notices;
}

Scene SceneOptions::scene(Scene scene) {
  if (!file_.empty()) {
    SceneFile read = read_scene_file(file_);
    scene = std::move(read.scene);
    layers_ = std::move(read.layers);
  }
  scene = with_settings(std::move(scene), camera_, settings_, file_z_is_up);
  Scene given = scene;
  // the look may bring a surface
  if (leaves_look_open(scene) || !scene.look.empty()) given.isovalue.reset();
  validate(given);
  return scene;
}

void FrameOptions::add_to(CommandLine& line) {
  line.add_option("IN.vdb", inputs,
                  "a volume; or a sequence: fire.####.vdb, a folder, or several files")
      ->type_name("")
      ->take_all();
  line.add_option("--frames", frames,
                  "frames of a sequence, such as 1-100, 1-100x2 or 1-10,20 (default: all)")
      ->type_name("A-B[xS]")
      ->group(frames_group);
  line.add_option("--auto-from", auto_from,
                  "frames from which extinction, camera, range, look and exposure are chosen for "
                  "all (default: the first, the middle and the last)")
      ->type_name("all|A-B[xS]")
      ->group(frames_group);
  line.add_option("--missing", missing,
                  "what to do about a frame without a file: refuse to start, leave it out, or take "
                  "the one before it")
      ->type_name("error|skip|hold")
      ->check(CLI::IsMember({"error", "skip", "hold"}).description(""))
      ->capture_default_str()
      ->group(frames_group);
}

}  // namespace psivox
