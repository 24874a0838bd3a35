#include "image/scene_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/trigonometric.hpp>
#include <vector>

#include "base/text.h"
#include "image/formats.h"
#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox {

Environment read_environment(const Scene& scene) {
  const Image image = read_image(scene.environment);
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::input, "--environment " + in_quotes(scene.environment) + ": " + why);
  };
  if (image.width != 2 * image.height)
    fail("a latitude-longitude map is twice as wide as high, and it has " +
         std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels");
  const auto rgba = image.rgba();
  const float scale = float(scene.environment_scale);
  std::vector<glm::vec3> radiance;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const glm::vec3 value(rgba[i], rgba[i + 1], rgba[i + 2]);
    if (!std::isfinite(value.x + value.y + value.z)) fail("it has pixels that are NaN or Inf");
    radiance.push_back(scale * glm::max(value, glm::vec3(0)));  // sharpening filters go below 0
  }
  if (std::ranges::all_of(radiance, [](const glm::vec3& L) { return L == glm::vec3(0); }))
    fail("it is black");
  return {{image.width, image.height},
          std::move(radiance),
          scene.up_axis == UpAxis::z,
          glm::radians(scene.environment_rotation)};
}

namespace {

/// Names that renderers give the depth, in lower case, the usual ones first.
constexpr std::array depth_names{"z", "depth", "pz"};

/// One channel of a picture that has been read.
struct ImageChannel {
  std::string name;  ///< as the file has it
  const Layer* layer;
  std::size_t index;

  /// `depth.Z` and, in Blender's files, `ViewLayer.Depth.Z` are called Z.
  std::string short_name() const { return lower_case(name.substr(name.rfind('.') + 1)); }
};

std::vector<ImageChannel> channels_of(const Image& image) {
  std::vector<ImageChannel> channels;
  for (const Layer& layer : image.layers)
    for (std::size_t i = 0; i < layer.channels.size(); ++i)
      channels.push_back({image_io::exr_channel_name(layer, i), &layer, i});
  return channels;
}

/// The channel of the depths; null if it is not clear which one has them.
const ImageChannel* depth_of(const std::vector<ImageChannel>& channels, const std::string& wanted) {
  const auto first = [&](const auto& is_it) -> const ImageChannel* {
    const auto found = std::ranges::find_if(channels, is_it);
    return found == channels.end() ? nullptr : &*found;
  };
  if (!wanted.empty())
    return first([&](const ImageChannel& channel) {
      return channel.name == wanted || channel.name == wanted + ".Z" ||
             channel.name == wanted + ".V" || channel.name == wanted + ".R";
    });
  for (const char* name : depth_names) {
    const auto has_it = [&](const auto& c) { return c.short_name() == name; };
    const auto count = std::ranges::count_if(channels, has_it);
    // the picture's own goes before those of layers
    if (count > 1) return first([&](const auto& c) { return lower_case(c.name) == name; });
    if (count == 1) return first(has_it);
  }
  // a file of depths alone: Blender's file output calls them V
  return channels.size() == 1 ? &channels.front() : nullptr;
}

Holdout read_holdout(const Scene& scene) {
  const LayerOfFile from(scene.holdout);
  const Image image = read_layers(from.file);
  const auto fail = [&](const std::string& why) {
    throw Error(ExitCode::input, "--holdout " + in_quotes(from.file) + ": " + why);
  };
  const glm::ivec2 size(image.width, image.height), wanted = scene.resolution;
  if (size != wanted)
    fail("it has " + std::to_string(size.x) + "x" + std::to_string(size.y) +
         " pixels in its display window, and the picture has " + std::to_string(wanted.x) + "x" +
         std::to_string(wanted.y) + "; both must be of one camera");
  const std::vector<ImageChannel> channels = channels_of(image);
  const ImageChannel* const depth = depth_of(channels, from.layer);
  if (!depth) {
    std::string names;
    for (const ImageChannel& channel : channels) names += " " + channel.name;
    fail((from.layer.empty() ? "no channel, or more than one, is called Z or depth"
                             : "it has no layer " + in_quotes(from.layer)) +
         "; name one as FILE.exr:LAYER of" + names);
  }
  Holdout holdout{size, scene.holdout_depth, {}};
  const std::vector<float>& values = depth->layer->values;
  const std::size_t stride = depth->layer->channels.size();
  for (std::size_t i = depth->index; i < values.size(); i += stride)
    holdout.depths.push_back(values[i]);
  return holdout;
}

}  // namespace

std::shared_ptr<const Holdout> NamedHoldout::of(const Scene& scene) {
  if (!kept_ || kept_->kind != scene.holdout_depth || kept_->size != scene.resolution ||
      name_ != scene.holdout) {
    kept_ = std::make_shared<const Holdout>(read_holdout(scene));
    name_ = scene.holdout;
  }
  return kept_;
}

}  // namespace psivox
