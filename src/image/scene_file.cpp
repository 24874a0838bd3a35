#include "psivox/scene_file.h"

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/parameters.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// Names of files in a scene.
constexpr std::string Scene::*file_names[] = {&Scene::input, &Scene::transfer_function,
                                              &Scene::holdout, &Scene::environment, &Scene::ocio};

/// Calls changed(file) for each file that the scene names and puts the result in its place.
template <typename Changed>
void change_files(Scene& scene, const Changed& changed) {
  for (std::string Scene::*const name : file_names) {
    LayerOfFile named(scene.*name);
    if (named.file.empty() || named.file.starts_with("ocio://")) continue;  // OpenColorIO's own
    named.file = changed(named.file);
    scene.*name = named.text();
  }
}

fs::path whole_path(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

bool is_there(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(path, unknown);
}

/// The file of that name in a scene that was written to `old_folder` and now is in `folder`.
std::string found(const std::string& name, const fs::path& folder, const fs::path& old_folder) {
  const fs::path path(name);
  const fs::path relative = path.is_absolute() ? path.lexically_relative(old_folder) : path;
  const fs::path beside = (folder / relative).lexically_normal();
  const bool moved = !relative.empty() && is_there(beside);
  // a scene in JSON names files from the working directory, as its command line did
  if (path.is_absolute()) return moved ? beside.string() : name;
  return is_there(path) || !moved ? name : beside.string();
}

}  // namespace

SceneFile read_scene_file(const std::string& path) {
  if (path.ends_with(".vdb") || path.ends_with(".nvdb"))
    throw Error(ExitCode::usage, in_quotes(path) +
                                     " is a volume, not a scene; give it without --scene, or give "
                                     "a .json or a picture that psivox wrote");
  SceneFile file;
  std::string text, old_folder;
  if (has_picture_extension(path)) {
    std::map<std::string, std::string> metadata = read_metadata(path);
    text = metadata["psivox:scene"];
    old_folder = metadata["psivox:folder"];
    file.layers = split(metadata["psivox:layers"]);
    if (text.empty())
      throw Error(ExitCode::input,
                  in_quotes(path) +
                      " has no psivox:scene in its metadata: psivox did not write it, another "
                      "program dropped it, or it is an .hdr or .webp, which hold none");
  } else {
    text = read_text(path, "scene");
  }
  file.scene = scene_from_json(text, path);
  const fs::path folder = fs::path(path).parent_path();
  change_files(file.scene,
               [&](const std::string& name) { return found(name, folder, old_folder); });
  return file;
}

void add_scene(const Scene& scene, const std::vector<std::string>& layers, const fs::path& picture,
               std::map<std::string, std::string>& metadata) {
  Scene named = scene;
  change_files(named, [](const std::string& name) { return whole_path(name).string(); });
  metadata["psivox:scene"] = to_json(named);
  metadata["psivox:folder"] = whole_path(picture).parent_path().string();
  if (!layers.empty()) metadata["psivox:layers"] = joined(layers);
}

}  // namespace psivox
