#include "scene_options.h"

#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox {
namespace {

std::string read_text(const std::string& path) {
  const auto fail = [&](const char* why) {
    throw Error(ExitCode::input, "cannot read scene " + in_quotes(path) + ": " + why);
  };
  if (std::filesystem::is_directory(path)) fail(std::strerror(EISDIR));
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) fail(std::strerror(errno));
  return text;
}

/// The scene in a picture's metadata, or in a JSON file.
std::string read_scene(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".exr" && extension != ".png") return read_text(path);
  std::string text = read_metadata(path, "psivox:scene");
  if (text.empty())
    throw Error(ExitCode::input, in_quotes(path) +
                                     " has no psivox:scene in its metadata: psivox did not write "
                                     "it, or another program dropped it");
  return text;
}

}  // namespace

void SceneOptions::add_to(CommandLine& line) {
  line.add_value("--scene", 0, "FILE",
                 "parameters from a .json, or from the metadata of an .exr or .png that psivox "
                 "wrote; the command line wins",
                 file_);
  line.add_parameters(settings_);
}

Scene SceneOptions::scene() const {
  Scene scene;
  if (!file_.empty()) scene = scene_from_json(read_scene(file_), file_);
  apply_over(scene, settings_);
  validate(scene);
  return scene;
}

}  // namespace psivox
