#include "oiio/channels.h"

#include <algorithm>
#include <map>

namespace psivox::image_io {
namespace {

std::optional<std::size_t> index_of(const std::vector<std::string>& names,
                                    const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

std::optional<LayerSource> picture_source(const std::vector<std::string>& names) {
  const auto red = index_of(names, "R");
  const auto green = index_of(names, "G");
  const auto blue = index_of(names, "B");
  const auto grey = index_of(names, "Y");
  const auto alpha = index_of(names, "A");
  const std::vector<std::string> channels = {"R", "G", "B", "A"};
  if (red && green && blue) return LayerSource{"", channels, {red, green, blue, alpha}};
  if (grey) return LayerSource{"", channels, {grey, grey, grey, alpha}};
  return std::nullopt;
}

}  // namespace

std::optional<std::vector<LayerSource>> layers_from_channels(
    const std::vector<std::string>& names) {
  const auto picture = picture_source(names);
  if (!picture) return std::nullopt;
  const auto& taken = picture->indices;

  std::vector<LayerSource> layers = {*picture};
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

}  // namespace psivox::image_io
