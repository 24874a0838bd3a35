#include "image/formats.h"

#include <algorithm>
#include <map>
#include <optional>

namespace psivox::image_io {
namespace {

/// A layer to read, and the places of its channels in the file.
struct LayerSource {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::optional<std::size_t>> indices;  ///< none: the channel is 1 everywhere
};

std::optional<std::size_t> index_of(const std::vector<std::string>& names,
                                    const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return std::size_t(found - names.begin());
}

std::optional<LayerSource> picture_source(const std::vector<std::string>& names) {
  const auto red = index_of(names, "R");
  const auto green = index_of(names, "G");
  const auto blue = index_of(names, "B");
  // beside X it is a vector's
  const auto grey = index_of(names, "X") ? std::nullopt : index_of(names, "Y");
  const auto alpha = index_of(names, "A");
  const std::vector<std::string> channels = {"R", "G", "B", "A"};
  if (red && green && blue) return LayerSource{"", channels, {red, green, blue, alpha}};
  if (grey) return LayerSource{"", channels, {grey, grey, grey, alpha}};
  return std::nullopt;
}

std::vector<LayerSource> sources_of(const std::vector<std::string>& names) {
  std::vector<LayerSource> layers;
  std::vector<std::optional<std::size_t>> taken;
  if (const auto picture = picture_source(names)) {
    layers.push_back(*picture);
    taken = picture->indices;
  }
  std::map<std::string, std::size_t> layer_of_prefix;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(taken.begin(), taken.end(), i) != taken.end()) continue;
    const std::size_t dot = names[i].rfind('.');
    if (dot == std::string::npos) {
      layers.push_back({names[i], {names[i]}, {i}});
      continue;
    }
    const std::string prefix = names[i].substr(0, dot);
    const auto [entry, is_new] = layer_of_prefix.try_emplace(prefix, layers.size());
    if (is_new) layers.push_back({prefix, {}, {}});
    layers[entry->second].channels.push_back(names[i].substr(dot + 1));
    layers[entry->second].indices.push_back(i);
  }
  // A channel alone under its prefix keeps its whole name, so that it is written under it again.
  for (const auto& [prefix, index] : layer_of_prefix) {
    LayerSource& layer = layers[index];
    if (layer.channels.size() != 1) continue;
    layer.name += "." + layer.channels.front();
    layer.channels.front() = layer.name;
  }
  return layers;
}

/// The part of the stored pixels that the window shows; 0 where the window has none.
Layer cut_layer(const LayerSource& source, const StoredPixels& stored, const Window& window) {
  const std::size_t count = source.channels.size();
  Layer layer{source.name, source.channels, {}};
  layer.values.resize(std::size_t(window.width) * std::size_t(window.height) * count);
  float* to = layer.values.data();
  for (std::int64_t y = window.y; y < window.y + window.height; ++y) {
    for (std::int64_t x = window.x; x < window.x + window.width; ++x, to += count) {
      if (x < 0 || x >= stored.width || y < 0 || y >= stored.height) continue;
      const auto from = std::size_t(y * stored.width + x) * stored.channels.size();
      for (std::size_t c = 0; c < count; ++c) {
        to[c] = source.indices[c] ? stored.values[from + *source.indices[c]] : 1.0f;
      }
    }
  }
  return layer;
}

}  // namespace

bool have_picture(const std::vector<std::string>& channels) {
  return picture_source(channels).has_value();
}

std::vector<Layer> layers_of_file(const StoredPixels& stored, const Window& window) {
  std::vector<Layer> layers;
  for (const LayerSource& source : sources_of(stored.channels))
    layers.push_back(cut_layer(source, stored, window));
  return layers;
}

}  // namespace psivox::image_io
