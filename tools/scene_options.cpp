#include "scene_options.h"

#include <algorithm>

#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/text.h"
#include "psivox/text_file.h"

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
  line.add_parameters(settings_, [&](const Parameter& p) {
    return std::find(without.begin(), without.end(), p.name) == without.end();
  });
}

Scene SceneOptions::scene(Scene scene) const {
  if (!file_.empty()) scene = scene_from_json(read_scene(file_), file_);
  apply_over(scene, settings_);
  validate(scene);
  return scene;
}

}  // namespace psivox
