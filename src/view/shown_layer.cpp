#include "view/shown_layer.h"

#include <algorithm>
#include <cmath>

#include "psivox/transfer_function.h"

namespace psivox::view {

void ask_for(ShownLayer layer, Scene& scene, RenderOptions& options) {
  options.count = layer == ShownLayer::steps;
  options.depth = layer == ShownLayer::depth;
  // the same depths, which it does not follow
  if (options.depth && scene.mode == Mode::back_to_front) scene.mode = Mode::alpha;
}

glm::dvec2 show_layer(ShownLayer layer, Image& image) {
  if (layer == ShownLayer::picture) return {0, 0};
  const char* name = layer == ShownLayer::steps ? "steps" : "depth";
  const auto found = std::find_if(image.layers.begin(), image.layers.end(),
                                  [&](const Layer& l) { return l.name == name; });
  if (found == image.layers.end()) return {0, 0};
  const std::vector<float>& values = found->values;
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, static_cast<double>(value));
    high = std::max(high, static_cast<double>(value));
  }
  if (layer == ShownLayer::steps) low = 0;
  if (!(low < high)) high = low + 1;
  const TransferFunction map = colormap_function(Colormap::viridis, low, high, low, high);
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool there = std::isfinite(values[i]);
    const glm::dvec3 color = there ? map.at(values[i]).color : glm::dvec3(0);
    for (std::size_t c = 0; c < 3; ++c)
      rgba[4 * i + c] = static_cast<float>(color[static_cast<int>(c)]);
    rgba[4 * i + 3] = there ? 1.0f : 0.0f;
  }
  return {low, high};
}

}  // namespace psivox::view
