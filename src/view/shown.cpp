#include "view/picture_maker.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "psivox/parameters.h"
#include "scene/color.h"

namespace psivox::view {
namespace {

/// Null if the picture has no such layer.
const Layer* layer_of(const Image& image, ShownLayer layer) {
  const auto found =
      std::ranges::find(image.layers, shown_layers[std::size_t(layer)], &Layer::name);
  return found == image.layers.end() ? nullptr : &*found;
}

/// Values at both ends of `range` have the ends of the colour map.
void paint(const std::vector<float>& values, const glm::dvec2& range, std::span<float> rgba) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool there = std::isfinite(values[i]);
    const double place = (double(values[i]) - range.x) / (range.y - range.x);
    const glm::dvec3 color = there ? colormap_color(Colormap::viridis, place) : glm::dvec3(0);
    for (std::size_t c = 0; c < 3; ++c) rgba[4 * i + c] = float(color[int(c)]);
    rgba[4 * i + 3] = there ? 1.0f : 0.0f;
  }
}

/// From best to cheapest.
constexpr std::array<Rung, 12> rungs{{{1, 1},
                                      {1.25, 1},
                                      {1.5, 1.25},
                                      {2, 1.25},
                                      {2, 2},
                                      {2.5, 2},
                                      {3, 2},
                                      {4, 2},
                                      {4, 3},
                                      {6, 3},
                                      {8, 4},
                                      {16, 6}}};

/// Cost relative to the first rung. Twice the step saves less than half, because crossing nodes
/// costs time too.
double cost_of(const Rung& rung) { return (0.3 + 0.7 / rung.step) / (rung.divisor * rung.divisor); }

/// Time of any picture, however small, to set up, draw and read back [ms].
constexpr double overhead_ms = 2;

}  // namespace

void ask_for(ShownLayer layer, Wish& wish) {
  wish.layers = layers_of({shown_layers[std::size_t(layer)]});
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
      low = std::min(low, double(value));
      high = std::max(high, double(value));
    }
  }
  if (layer != ShownLayer::depth || low > high) low = 0;
  if (!(low < high)) high = low + 1;
  for (Image& image : images) paint(layer_of(image, layer)->values, {low, high}, image.rgba());
  return {low, high};
}

Scene coarser(const Scene& scene) {
  Scene result = scene;
  result.tolerance.reset();
  if (scene.shows(Shows::surface)) return result;
  result.step = 2 * scene.resolved_step();
  result.sampling = Sampling::uniform;
  result.integrator.reset();
  return result;
}

Scene with_method_of(const Scene& other, Scene scene) {
  for (const Parameter& p : parameters()) {
    const bool differs = p.group == ParameterGroup::accuracy && p.name != "split-knots" &&
                         p.under_tolerance != UnderTolerance::unchanged;
    if (differs) copy_parameter(other, scene, p);
  }
  return scene;
}

Rung Pace::rung() const { return rungs[std::size_t(index_)]; }

void Pace::took(const Rung& rung, double ms) {
  const double full = std::max(ms - overhead_ms, 0.1) / cost_of(rung);
  // A slow picture counts at once, fast ones gradually: times vary, and the preview should not
  // flicker between two rungs.
  cost_ms_ = known_ && full < cost_ms_ ? 0.8 * cost_ms_ + 0.2 * full : full;
  known_ = true;
  const auto expected = [&](int i) {
    return overhead_ms + cost_ms_ * cost_of(rungs[std::size_t(i)]);
  };
  const int last = int(rungs.size()) - 1;
  while (index_ < last && expected(index_) > budget_ms_) ++index_;
  while (index_ > 0 && expected(index_ - 1) < 0.85 * budget_ms_) --index_;
}

Scene preview_scene(const Scene& scene, const Rung& rung) {
  Scene preview = scene;
  const auto part = [&](int pixels) {
    return std::max(1, int(std::lround(pixels / rung.divisor)));
  };
  preview.resolution = {part(scene.resolution.x), part(scene.resolution.y)};
  preview.pixel_samples = 1;
  preview.end_corrections = false;
  preview.tolerance.reset();
  preview.renderer = RendererKind::gl;
  if (scene.shows(Shows::surface) || is_transfer_rule(scene.resolved_integrator())) return preview;
  preview.sampling = Sampling::uniform;
  preview.connectivity = Scene{}.connectivity;
  preview.step = std::max(rung.step, scene.step.value_or(0.0));
  if (preview.integrator && is_cell_rule(*preview.integrator)) preview.integrator.reset();
  return preview;
}

}  // namespace psivox::view
