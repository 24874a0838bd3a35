#include "picture_output.h"

#include <filesystem>

#include "psivox/color_scale.h"
#include "psivox/stopwatch.h"
#include "psivox/text.h"
#include "scene_file.h"

namespace psivox {
namespace {

void composite(Image& image, const glm::dvec3& background) {
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const double behind = 1 - static_cast<double>(rgba[i + 3]);
    for (int c = 0; c < 3; ++c) {
      float& value = rgba[i + static_cast<std::size_t>(c)];
      value = static_cast<float>(static_cast<double>(value) + behind * background[c]);
    }
    rgba[i + 3] = 1;
  }
}

/// Of codes that are brighter than white; empty if they are few.
std::string clipping_notice(const RenderReport& report, const Scene& scene) {
  const double share = double(report.clipped) / double(report.drawn.image.rgba().size() / 4);
  if (share <= 0.01) return {};
  std::string advice = "--exposure auto";
  if (scene.tone_map == ToneMap::none) advice += ", perhaps with --tone-map filmic,";
  return percent_text(share) + " of the pixels are brighter than white; " + advice +
         " shows their light";
}

/// Returns why there is no bar.
std::string add_color_bar(const View& view, const Display& display, Image& image) {
  const std::optional<ColorScale> scale = color_scale(view);
  if (!scale) return "--color-bar: the transfer function has no colours";
  if (!draw_color_bar(image, *scale, display))
    return "--color-bar: the picture is too small for it";
  return {};
}

}  // namespace

bool shows_background(const RenderCall& call) {
  if (call.scene.gives("background")) return false;
  if (call.output.empty()) return !call.movie.empty();
  return !holds_layers(call.output) && !call.output.ends_with(".tif");
}

std::map<std::string, std::string> picture_metadata(const RenderCall& call,
                                                    const std::string& output, const Scene& scene) {
  std::map<std::string, std::string> metadata;
  add_scene(scene, call.layers, output, metadata);
  metadata["psivox:version"] = PSIVOX_VERSION;
  if (call.format.bits) metadata["psivox:bits"] = std::to_string(*call.format.bits);
  if (call.format.half) metadata["psivox:half"] = "true";
  return metadata;
}

std::vector<std::string> write_picture(const RenderCall& call, const std::string& output,
                                       const View& view, RenderReport& report) {
  std::vector<std::string> notices;
  const auto say = [&](const std::string& notice) {
    if (!notice.empty()) notices.push_back(notice);
  };
  Image& image = report.drawn.image;
  Scene scene = view.scene;
  if (!scene.exposure && holds_codes(output, call.format)) {
    scene.exposure = auto_exposure(image, scene.tone_map);
    say("exposure " + number_text(*scene.exposure) + " [powers of 2], chosen by auto");
  }
  WriteOptions format = call.format;
  if (holds_codes(output, call.format))
    format.display = {scene.exposure.value_or(0), scene.tone_map};
  if (scene.background) composite(image, *scene.background);
  if (scene.color_bar && holds_codes(output, call.format))
    say(add_color_bar(view, format.display, image));
  image.metadata = picture_metadata(call, output, scene);
  image.metadata["psivox:renderer"] = report.drawn.stats.renderer;
  const Stopwatch writing;
  say(write_image(image, output, format));
  report.write_ms = writing.ms();
  report.clipped = clipping(image, output, format).clipped;
  say(clipping_notice(report, scene));
  std::error_code not_a_file;
  const std::uintmax_t written = std::filesystem::file_size(output, not_a_file);
  report.output_bytes = not_a_file ? 0 : written;
  return notices;
}

}  // namespace psivox
