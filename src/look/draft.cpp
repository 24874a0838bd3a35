#include "look/draft.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "psivox/draw.h"
#include "psivox/method.h"

namespace psivox {
namespace {

/// A pixel counts if it hides this much or is that bright.
constexpr float covered_alpha = 0.5f;
constexpr double covered_luminance = 0.1;

}  // namespace

double Draft::mean_luminance() const {
  if (luminance.empty()) return 0;
  return std::accumulate(luminance.begin(), luminance.end(), 0.0) / double(luminance.size());
}

double Draft::level(double part) const {
  if (brightest.empty()) return 0;
  return brightest[std::size_t(double(brightest.size() - 1) * (1 - part))];
}

Image draft_picture(Scene scene, const MediumFields& fields) {
  scene.background.reset();
  // whatever method is given for the picture
  scene = with_method(
      std::move(scene),
      {.integrator = Integrator::psi_balanced, .sampling = Sampling::uniform, .step = 2});
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
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const double r = double(rgba[i]), g = double(rgba[i + 1]), b = double(rgba[i + 2]);
    const double luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    if (rgba[i + 3] < covered_alpha && luminance < covered_luminance) continue;
    draft.luminance.push_back(luminance);
    draft.brightest.push_back(std::max({r, g, b}));
  }
  std::sort(draft.luminance.begin(), draft.luminance.end());
  std::sort(draft.brightest.begin(), draft.brightest.end());
  return draft;
}

}  // namespace psivox
