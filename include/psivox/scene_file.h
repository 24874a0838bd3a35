#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// A scene as a file holds it.
struct SceneFile {
  Scene scene;
  std::vector<std::string> layers{};  ///< that the picture was drawn with, named as in --aov
};

/// Reads a scene from JSON or from the metadata of a picture that psivox wrote. The files that it
/// names are looked for where they were relative to the scene's file, then under their own names,
/// which in a picture are absolute. Throws Error(input), Error(usage).
SceneFile read_scene_file(const std::string& path);

/// Metadata from which read_scene_file reads the scene again, wherever the picture and its inputs
/// are moved together.
void add_scene(const Scene& scene, const std::vector<std::string>& layers,
               const std::filesystem::path& picture, std::map<std::string, std::string>& metadata);

}  // namespace psivox
