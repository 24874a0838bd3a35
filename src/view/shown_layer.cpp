#include "view/shown_layer.h"

#include <algorithm>
#include <cmath>

#include "psivox/transfer_function.h"

namespace psivox::view {
namespace {

/// Null if the picture has no such layer.
const Layer* layer_of(const Image& image, ShownLayer layer) {
  const auto found = std::find_if(image.layers.begin(), image.layers.end(), [&](const Layer& l) {
    return l.name == shown_layers[static_cast<std::size_t>(layer)];
  });
  return found == image.layers.end() ? nullptr : &*found;
}

void paint(const std::vector<float>& values, const TransferFunction& map, std::span<float> rgba) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool there = std::isfinite(values[i]);
    const glm::dvec3 color = there ? map.at(values[i]).color : glm::dvec3(0);
    for (std::size_t c = 0; c < 3; ++c)
      rgba[4 * i + c] = static_cast<float>(color[static_cast<int>(c)]);
    rgba[4 * i + 3] = there ? 1.0f : 0.0f;
  }
}

}  // namespace

void ask_for(ShownLayer layer, Wish& wish) {
  wish.layers.steps = layer == ShownLayer::steps;
  wish.layers.depth = layer == ShownLayer::depth;
  wish.layers.error = layer == ShownLayer::error;
  // alpha has the same depths, and back-to-front does not compute them
  if (wish.layers.depth) wish.scene->mode = from_front(wish.scene->mode);
}

glm::dvec2 show_layer(ShownLayer layer, std::span<Image> images) {
  if (layer == ShownLayer::picture) return {0, 0};
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const Image& image : images) {
    const Layer* values = layer_of(image, layer);
    if (!values) return {0, 0};
    for (const float value : values->values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, static_cast<double>(value));
      high = std::max(high, static_cast<double>(value));
    }
  }
  if (layer != ShownLayer::depth || low > high) low = 0;
  if (!(low < high)) high = low + 1;
  const TransferFunction map = colormap_function(Colormap::viridis, low, high, low, high);
  for (Image& image : images) paint(layer_of(image, layer)->values, map, image.rgba());
  return {low, high};
}

}  // namespace psivox::view
