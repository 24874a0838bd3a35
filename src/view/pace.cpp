#include "view/pace.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace psivox::view {
namespace {

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

Rung Pace::rung() const { return rungs[static_cast<std::size_t>(index_)]; }

void Pace::took(const Rung& rung, double ms) {
  const double full = std::max(ms - overhead_ms, 0.1) / cost_of(rung);
  // A slow picture counts at once, fast ones gradually: times vary, and the preview should not
  // flicker between two rungs.
  cost_ms_ = known_ && full < cost_ms_ ? 0.8 * cost_ms_ + 0.2 * full : full;
  known_ = true;
  const auto expected = [&](int i) {
    return overhead_ms + cost_ms_ * cost_of(rungs[static_cast<std::size_t>(i)]);
  };
  const int last = static_cast<int>(rungs.size()) - 1;
  while (index_ < last && expected(index_) > budget_ms_) ++index_;
  while (index_ > 0 && expected(index_ - 1) < 0.85 * budget_ms_) --index_;
}

Scene preview_scene(const Scene& scene, const Rung& rung) {
  Scene preview = scene;
  const auto part = [&](int pixels) {
    return std::max(1, static_cast<int>(std::lround(pixels / rung.divisor)));
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
