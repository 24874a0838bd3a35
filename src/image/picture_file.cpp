#include "psivox/picture_file.h"

#include <cstdlib>
#include <glm/geometric.hpp>

#include "base/input_file.h"
#include "base/memory.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/text_file.h"
#include "psivox/camera.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

/// More than this part of the pixels being brighter than white is said.
constexpr double few_pixels = 0.01;

/// Tells of codes that are brighter than white, `clipped` of them before there is a background;
/// empty if they are few. `asked`: the scene before an exposure was chosen.
std::string clipping_notice(std::size_t clipped, const Image& image, const Scene& asked,
                            const PictureFile& file, const WriteOptions& format) {
  const auto pixels = double(image.rgba().size() / 4);
  if (double(clipped) <= few_pixels * pixels) return {};
  WriteOptions filmic = format;
  filmic.display.tone_map = ToneMap::filmic;
  const auto open = [&](const char* name) { return !asked.given.contains(name); };
  std::string advice;
  if (asked.exposure && open("exposure"))
    advice = "; --exposure auto shows their light";
  else if (asked.tone_map == ToneMap::none && open("tone-map") && !asked.uses_ocio() &&
           double(clipping(image, file.path, filmic).clipped) <= few_pixels * pixels)
    advice = "; --tone-map filmic shows their light";
  return percent_text(double(clipped) / pixels) + " of the pixels are brighter than white" + advice;
}

/// Chooses the exposure that the scene leaves open, by the light in front of the background.
/// Returns what to say.
std::string choose_exposure(const Image& image, Scene& scene) {
  if (scene.exposure) return {};
  scene.exposure = auto_exposure(image, scene.tone_map);
  return "exposure " + formatted("%.3g", *scene.exposure) + ", chosen by auto";
}

/// The light of lines and texts that are seen on a background.
double ink_on(const std::optional<Background>& background) {
  constexpr double middle = 0.18;  // grey
  if (!background || background->environment) return 0.4;
  return glm::dot(background->color, glm::dvec3(0.2126, 0.7152, 0.0722)) > middle ? 0.03 : 0.6;
}

namespace fs = std::filesystem;

/// Names of files in a scene.
constexpr std::string Scene::*file_names[] = {&Scene::input, &Scene::transfer_function,
                                              &Scene::holdout, &Scene::environment, &Scene::ocio};

/// Calls changed(file) for each file that the scene names and puts the result in its place.
template <typename Changed>
void change_files(Scene& scene, const Changed& changed) {
  const auto renamed = [&](const std::string& name) {
    LayerOfFile named(name);
    if (named.file.empty() || named.file.starts_with("ocio://")) return name;  // OpenColorIO's own
    named.file = changed(named.file);
    return named.text();
  };
  for (std::string Scene::*const name : file_names) scene.*name = renamed(scene.*name);
  for (std::string& volume : scene.volumes) {
    const std::string name = scene_of_volume(scene, volume).input;
    volume = renamed(name) + volume.substr(name.size());
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

bool shows_background(const std::string& path, const WriteOptions& format) {
  const bool tiff = path.ends_with(".tif") || path.ends_with(".tiff");
  return !holds_layers(path) && (!tiff || format.bits);
}

std::map<std::string, std::string> picture_metadata(const PictureFile& file, const Scene& scene) {
  std::map<std::string, std::string> metadata;
  add_scene(scene, file.layers, file.path, metadata);
  metadata["psivox:version"] = PSIVOX_VERSION;
  if (file.format.bits) metadata["psivox:bits"] = std::to_string(*file.format.bits);
  if (file.format.half) metadata["psivox:half"] = "true";
  return metadata;
}

Display display_of(const Scene& scene) {
  return {scene.exposure.value_or(0),
          scene.tone_map,
          {scene.ocio, scene.ocio_display, scene.ocio_view, scene.ocio_space}};
}

void resolve_ocio(Scene& scene) {
  if (!scene.uses_ocio()) return;
  if (const char* const named = std::getenv("OCIO"); scene.ocio.empty() && named)
    scene.ocio = named;
  if (scene.ocio.empty())
    throw Error(ExitCode::usage,
                "the --ocio options need a config; give --ocio FILE, or set OCIO to one");
  const OcioView view = complete_view(display_of(scene).ocio);
  scene.ocio_display = view.display;
  scene.ocio_view = view.view;
  scene.ocio_space = view.space;
}

void add_background(Image& image, const glm::dvec3& color, const std::vector<glm::vec3>& behind) {
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const double left = 1 - static_cast<double>(rgba[i + 3]);
    const glm::dvec3 background = behind.empty() ? color : glm::dvec3(behind[i / 4]);
    for (int c = 0; c < 3; ++c) {
      float& value = rgba[i + static_cast<std::size_t>(c)];
      value = static_cast<float>(static_cast<double>(value) + left * background[c]);
    }
    rgba[i + 3] = 1;
  }
}

std::vector<std::string> complete_picture(Image& image, Scene& scene, const Legend& legend,
                                          bool codes) {
  std::vector<std::string> notices;
  const auto say = [&](const std::string& notice) {
    if (!notice.empty()) notices.push_back(notice);
  };
  if (codes) {
    say(choose_exposure(image, scene));
    resolve_ocio(scene);
    draw_lines_behind(image, legend, display_of(scene));
  }
  if (scene.background) add_background(image, scene.background->color, legend.behind);
  if (!codes) return notices;
  const Display display = display_of(scene);
  if (scene.color_bar && !legend.colors)
    say("--color-bar: no map gives the values a colour");
  else if (scene.color_bar && !draw_color_bar(image, *legend.colors, display))
    say("--color-bar: the picture is too small for it");
  if (legend.lengths && !draw_scale_bar(image, *legend.lengths, display))
    say("--scale-bar: the picture is too small for it");
  draw_annotations(image, legend, ink_on(scene.background), display);
  return notices;
}

WrittenPicture write_picture(Image& image, Scene scene, const Legend& legend,
                             const std::string& renderer, const PictureFile& file) {
  WriteOptions format = file.format;
  const bool codes = holds_codes(file.path, format);
  WrittenPicture written;
  const auto say = [&](const std::string& notice) {
    if (!notice.empty()) written.notices.push_back(notice);
  };
  const Scene asked = scene;
  if (codes) {
    say(choose_exposure(image, scene));
    resolve_ocio(scene);
    format.display = display_of(scene);
  }
  // the background may be as bright as it likes
  written.clipped = clipping(image, file.path, format).clipped;
  const std::string too_bright = clipping_notice(written.clipped, image, asked, file, format);
  for (const std::string& notice : complete_picture(image, scene, legend, codes)) say(notice);
  image.metadata = picture_metadata(file, scene);
  image.metadata["psivox:renderer"] = renderer;
  if (scene.camera_position && scene.camera_target && scene.camera_up) {
    // glm's columns for column vectors are OpenEXR's rows for row vectors
    const auto [camera, ndc] = camera_matrices(make_camera(scene, glm::dvec3(-1), glm::dvec3(1)));
    image.matrices = {{"worldToCamera", glm::mat4(camera)}, {"worldToNDC", glm::mat4(ndc)}};
  }
  const Stopwatch writing;
  say(write_image(image, file.path, format));
  written.write_ms = writing.ms();
  say(too_bright);
  std::error_code not_a_file;
  const std::uintmax_t bytes = std::filesystem::file_size(file.path, not_a_file);
  written.bytes = not_a_file ? 0 : bytes;
  return written;
}

void check_picture_memory(int width, int height, int layers, int code_bytes) {
  const double pixel = 4 * (4 + layers) + code_bytes;
  const double needed = pixel * width * height;
  const auto usable = double(available_memory());
  if (usable == 0 || needed <= usable) return;
  throw Error(ExitCode::memory,
              formatted("a picture of %dx%d takes %.1f GiB of memory, and %.1f GiB are free; give "
                        "a smaller --resolution",
                        width, height, needed / 0x1p30, usable / 0x1p30));
}

SceneFile read_scene_file(const std::string& path) {
  if (path.ends_with(".vdb") || path.ends_with(".nvdb"))
    throw Error(ExitCode::usage, in_quotes(path) +
                                     " is a volume, not a scene; give it without --scene, or give "
                                     "a .json or a picture that psivox wrote");
  SceneFile file;
  std::string text, old_folder;
  if (path != "-" && has_picture_extension(path)) {
    const EarlierOutput drawn;
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

std::vector<std::string> files_of(Scene scene) {
  std::vector<std::string> files;
  change_files(scene, [&](const std::string& name) {
    files.push_back(name);
    return name;
  });
  return files;
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
