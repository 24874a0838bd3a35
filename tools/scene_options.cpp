#include "scene_options.h"

#include <algorithm>
#include <utility>

#include "psivox/open.h"
#include "psivox/scene_file.h"
#include "psivox/sequence.h"
#include "psivox/vdb.h"

namespace psivox {

bool file_z_is_up(const Scene& scene) {
  if (scene.up_axis != UpAxis::automatic || scene.input.empty()) return scene.up_axis == UpAxis::z;
  const auto files = sequence_files(std::vector{scene.input});
  return !VdbFile(files ? files->begin()->second : scene.input).z_up().empty();
}

void SceneOptions::add_to(CommandLine& line, const std::vector<std::string>& without) {
  line.begin_group(group_name(ParameterGroup::input));
  line.add_value("--scene", file_, "FILE",
                 "read parameters from a .json, or from a picture that psivox wrote; the command "
                 "line overrides them");
  line.add_trust();
  line.begin_group(group_name(ParameterGroup::camera));
  line.add_value("--camera", camera_, "FILE[:NAME]",
                 "camera of a .gltf, .glb or ParaView's .pvcc; :NAME of one of several");
  line.add_parameters(settings_,
                      [&](const Parameter& p) { return std::ranges::count(without, p.name) == 0; });
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
  line.begin_group("Frames");
  line.add_value("IN.vdb", inputs, "",
                 "a volume; or a sequence: fire.####.vdb, a folder, or several files")
      ->take_all();
  line.add_value("--frames", frames, "A-B[xS]",
                 "frames of a sequence, such as 1-100, 1-100x2 or 1-10,20 (default: all)");
  line.add_value("--auto-from", auto_from, "all|A-B[xS]",
                 "frames from which extinction, camera, range, look and exposure are chosen for "
                 "all (default: the first, the middle and the last)");
  line.add_value("--missing", missing, "error|skip|hold",
                 "what to do about a frame without a file: refuse to start, leave it out, or take "
                 "the one before it")
      ->check(one_of<std::string>({"error", "skip", "hold"}))
      ->capture_default_str();
}

}  // namespace psivox
