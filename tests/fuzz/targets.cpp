#include "targets.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "packed_grid.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"
#include "psivox/sequence.h"
#include "psivox/vdb.h"
#include "render_call.h"
#include "scene/camera_file.h"
#include "scene/transfer_function.h"
#include "sequence/camera_motion.h"

namespace psivox::fuzz {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

/// A file of this process that holds the bytes, until the next one of the same extension.
std::filesystem::path file_with(std::string_view bytes, const std::string& extension) {
  static const struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("psivox_fuzz_" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  } folder;
  const auto path = folder.path / ("input" + extension);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

void require_same_again(const Scene& scene) {
  const std::string text = to_json(scene);
  require(to_json(scene_from_json(text)) == text, "a scene changes when it is read again");
}

void read_scene(std::string_view bytes) { require_same_again(scene_from_json(bytes)); }

void read_function(std::string_view bytes) {
  const TransferFunction function = transfer_function_from_json(bytes, "fuzz");
  const TransferFunction again = transfer_function_from_json(to_json(function), "fuzz");
  require(again == function, "a transfer function changes when it is read again");
}

void read_camera_file(std::string_view bytes, const char* extension) {
  const std::string path = file_with(bytes, extension).string();
  try {
    read_camera(path, false);
  } catch (const Error&) {  // the animation may be read without it
  }
  const CameraAnimation animation = read_camera_animation(path, true);
  for (const double part : {-0.5, 0.0, 0.3, 1.0, 1.5})
    animation.at(animation.begin + part * (animation.end - animation.begin));
}

void read_path(std::string_view bytes) {
  const CameraPath path = CameraPath::read(file_with(bytes, ".json").string(), false, 24);
  for (const double frame : {path.first() - 1, (path.first() + path.last()) / 2, path.last() + 1})
    path.at(Scene(), frame);
}

void read_frame_names(std::string_view bytes) {
  const std::string text(bytes);
  for (const auto of : {FramePattern::of_placeholder, FramePattern::of_number}) {
    try {
      const auto pattern = of(text);
      if (pattern)
        require(pattern->frame_of(pattern->path(7)) == 7, "a frame's name is not its own");
    } catch (const Error&) {  // the other may take it
    }
  }
  const std::vector<FrameNumber> frames = read_frames(text, "--frames");
  require(read_frames(frames_text(frames), "--frames") == frames, "frames change as text");
}

/// One parameter in the command line's syntax: `name value`.
void read_parameter(std::string_view bytes) {
  const std::size_t space = bytes.find(' ');
  if (space == bytes.npos) return;
  const Setting setting{std::string(bytes.substr(0, space)), std::string(bytes.substr(space + 1))};
  Scene scene;
  apply_over(scene, std::span(&setting, 1));
  validate(scene);
}

/// The arguments of `psivox render`, one in a line. Files that they name do not exist.
void read_command_line(std::string_view bytes) {
  std::filesystem::current_path(file_with({}, ".empty").parent_path());
  std::vector<std::string> arguments;
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) arguments.push_back(line);
  RenderCall call;
  if (!parse(call, arguments)) return;
  const Scene scene = call.scene.scene();
  require_same_again(scene);
  take_layers(call, scene);
  wish_of(call);
  if (!call.sequence.frames.empty()) read_frames(call.sequence.frames, "--frames");
}

void read_picture(std::string_view bytes) {
  const auto path = file_with(bytes, ".picture");
  read_metadata(path);
  read_image(path);
}

/// As one of several ranks does: values stay in the file.
void read_in_file(const VolumeFile& file) {
  const Field field = file.read(file.default_grid(), {.in_file = true});
  if (!field.reader) return;
  constexpr std::size_t at_once = 1024;
  std::vector<float> values(at_once * 512 * std::size_t(field.channels));
  std::vector<std::uint32_t> leaves(field.leaves.size());
  std::iota(leaves.begin(), leaves.end(), 0);
  for (std::size_t n = 0; n < leaves.size(); n += at_once)
    field.reader(field, std::span(leaves).subspan(n, std::min(at_once, leaves.size() - n)),
                 values.data());
}

void read_volume(std::string_view bytes) {
  const VolumeFile file(file_with(bytes, ".vdb"));
  file.info();
  try {
    read_in_file(file);
  } catch (const Error&) {
  }
  const Field field = file.read(file.default_grid());
  constexpr std::uint64_t most = 64 << 20;
  if (predict_atlas(field).bytes() <= most) build_atlas(field);
  Scene scene;
  scene.resolution = {1, 1};
  scene.extinction = 1.0;
  Session session(make_view(scene, file));
  session.draw(*open_double(), {});
}

}  // namespace

std::span<const Target> targets() {
  static const auto table = std::to_array<Target>({
      {"scene", read_scene},
      {"function", read_function},
      {"gltf", [](std::string_view bytes) { read_camera_file(bytes, ".gltf"); }},
      {"glb", [](std::string_view bytes) { read_camera_file(bytes, ".glb"); }},
      {"pvcc", [](std::string_view bytes) { read_camera_file(bytes, ".pvcc"); }},
      {"path", read_path},
      {"frames", read_frame_names},
      {"parameter", read_parameter},
      {"command", read_command_line},
      {"volume", read_volume},
      {"scan", read_volume},  // the first bytes tell the format
      {"nano", [](std::string_view packed) { read_volume(unpacked_grid(packed)); }},
      {"picture", read_picture},
  });
  return table;
}

void run(std::string_view name, std::string_view bytes) {
  for (const Target& target : targets()) {
    if (target.name != name) continue;
    try {
      target.read(bytes);
    } catch (const Error&) {
    }
    return;
  }
  throw std::logic_error("no fuzz target '" + std::string(name) + "'");
}

}  // namespace psivox::fuzz
