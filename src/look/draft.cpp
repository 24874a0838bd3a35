#include "look/draft.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "medium/value_range.h"
#include "psivox/draw.h"
#include "psivox/method.h"

namespace psivox {
namespace {

/// A pixel counts if it hides this much or is that bright.
constexpr double covered_alpha = 0.5;
constexpr double covered_luminance = 0.1;
/// And glows with this part of the brightest one.
constexpr float glowing = 0.01f;

/// The value that this part of ascending ones exceeds.
template <typename Number>
Number exceeded_by(const std::vector<Number>& ascending, double part) {
  if (ascending.empty()) return 0;
  return ascending[std::size_t(double(ascending.size() - 1) * (1 - part))];
}

/// Whatever method is given for the picture.
Method draft_method(const Scene& scene, const Field& density) {
  if (scene.emission_grid.empty())
    return {.integrator = Integrator::psi_balanced, .sampling = Sampling::uniform, .step = 2};
  // light that leaves less than a step needs cells
  constexpr double step = 4;
  const double most = scene.extinction.value_or(0) * stored_range(density).y;
  if (most * step * glm::length(glm::dvec3(density.world_from_index[0])) > 8)
    return {.segments = 2};
  // a step looks up one value
  return {.integrator = Integrator::midpoint, .sampling = Sampling::uniform, .step = step};
}

}  // namespace

double Draft::mean_luminance() const {
  if (luminance.empty()) return 0;
  return std::accumulate(luminance.begin(), luminance.end(), 0.0) / double(luminance.size());
}

double Draft::level(double part) const { return exceeded_by(brightest, part); }

void Draft::see(const glm::dvec3& radiance, double alpha) {
  const double light = 0.2126 * radiance.x + 0.7152 * radiance.y + 0.0722 * radiance.z;
  if (alpha < covered_alpha && light < covered_luminance) return;
  luminance.push_back(light);
  brightest.push_back(std::max({radiance.x, radiance.y, radiance.z}));
}

void Draft::sort() {
  std::sort(luminance.begin(), luminance.end());
  std::sort(brightest.begin(), brightest.end());
}

Image draft_picture(Scene scene, const MediumFields& fields) {
  scene.background.reset();
  scene.holdout.clear();
  scene = with_method(scene, draft_method(scene, *fields.density));
  scene.connectivity = Scene{}.connectivity;
  scene.resolution = {96, 54};
  scene.pixel_samples = 1;
  scene.memory_limit = 0;  // its march in double needs the whole atlas, on the host alone
  return Session(make_view(scene, fields)).draw(*open_double(), {.any_light = true}).image;
}

Draft make_draft(const Scene& scene, const MediumFields& fields) {
  const Image image = draft_picture(scene, fields);
  Draft draft;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    draft.see(glm::dvec3(rgba[i], rgba[i + 1], rgba[i + 2]), double(rgba[i + 3]));
  draft.sort();
  return draft;
}

double glow_level(const Image& image, double part) {
  std::vector<float> glow;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    glow.push_back(std::max({rgba[i], rgba[i + 1], rgba[i + 2]}));
  const float least = glowing * std::ranges::max(glow);
  std::erase_if(glow, [&](float value) { return !(value > 0 && value >= least); });
  std::ranges::sort(glow);
  return double(exceeded_by(glow, part));
}

}  // namespace psivox
