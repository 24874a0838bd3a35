#include "psivox/legend.h"
#include "scene/environment.h"
#include "scene/transfer_function.h"

#include <algorithm>
#include <cmath>

namespace psivox {
namespace {

constexpr int color_count = 256;

template <typename ColorOfValue>
ColorScale scale_of(const View& view, double min, double max, const ColorOfValue& color) {
  ColorScale scale{view.scene.grid, min, max, {}};
  for (int i = 0; i < color_count; ++i)
    scale.colors.push_back(view.scene.resolved_luminance() *
                           color(std::lerp(min, max, i / double(color_count - 1))));
  return scale;
}

}  // namespace

std::optional<ColorScale> color_scale(const View& view) {
  const Scene& scene = view.scene;
  if (scene.windows()) {
    if (!scene.colormap && !scene.shows(Shows::value)) return std::nullopt;
    const glm::dvec2 range = scene.range->ends;
    return scale_of(view, range.x, range.y, [&](double value) {
      const double u = (value - range.x) / (range.y - range.x);
      return scene.colormap ? colormap_color(*scene.colormap, u) : glm::dvec3(u);
    });
  }
  if (scene.transfer_function.empty()) return std::nullopt;
  const TransferFunction function = read_transfer_function(scene.transfer_function);
  const double first = function.points().empty() ? 0 : function.points().front().value;
  const double last = function.points().empty() ? 0 : function.points().back().value;
  if (!function.has_color() || !(first < last)) return std::nullopt;
  return scale_of(view, first, last, [&](double value) { return function.at(value).color; });
}

Legend legend_of(const View& view) {
  Legend legend;
  if (view.scene.color_bar) legend.colors = color_scale(view);
  if (view.scene.scale_bar) legend.lengths = scale_bar(view);
  const glm::ivec2 size = view.scene.resolution;
  if (view.environment && view.scene.background && view.scene.background->environment)
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x)
        legend.behind.emplace_back(
            view.environment->at(camera_ray(view.camera, size, x + 0.5, y + 0.5).direction));
  return legend;
}

}  // namespace psivox
