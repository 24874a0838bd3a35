#include "scene_options.h"

#include <algorithm>

#include "psivox/camera_file.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "psivox/vdb.h"

namespace psivox {
namespace {

/// The scene in a picture's metadata, or in a JSON file.
std::string read_scene(const std::string& path) {
  if (path.ends_with(".vdb"))
    throw Error(ExitCode::usage, in_quotes(path) +
                                     " is a volume, not a scene; give it without --scene, or give "
                                     "a .json or a picture that psivox wrote");
  if (!has_picture_extension(path)) return read_text(path, "scene");
  std::string text = read_metadata(path, "psivox:scene");
  if (text.empty())
    throw Error(ExitCode::input, in_quotes(path) +
                                     " has no psivox:scene in its metadata: psivox did not write "
                                     "it, another program dropped it, or it is an .hdr or .webp, "
                                     "which hold none");
  return text;
}

}  // namespace

void SceneOptions::add_to(CommandLine& line, std::span<const std::string> without) {
  line.add_option("--scene", file_,
                  "read parameters from a .json, or from a picture that psivox wrote; the command "
                  "line overrides them")
      ->type_name("FILE")
      ->group(group_name(ParameterGroup::input));
  line.add_option("--camera", camera_,
                  "camera of a .gltf, .glb or ParaView's .pvcc; :NAME of one of several")
      ->type_name("FILE[:NAME]")
      ->group(group_name(ParameterGroup::camera));
  line.add_parameters(settings_, [&](const Parameter& p) {
    return std::find(without.begin(), without.end(), p.name) == without.end();
  });
}

/// The camera of the file, for the picture and the up axis that the settings name.
void SceneOptions::use_camera(Scene& scene) const {
  Scene known = scene;
  apply_over(known, settings_);
  bool z_up = known.up_axis == UpAxis::z;
  if (known.up_axis == UpAxis::automatic && !known.input.empty())
    z_up = !VdbFile(known.input).z_up().empty();
  const FileCamera camera = read_camera(camera_, z_up);
  scene.resolution = known.resolution;
  set_camera(scene, camera);
}

Scene SceneOptions::scene(Scene scene) const {
  if (!file_.empty()) scene = scene_from_json(read_scene(file_), file_);
  if (!camera_.empty()) use_camera(scene);
  apply_over(scene, settings_);
  validate(scene);
  return scene;
}

}  // namespace psivox
