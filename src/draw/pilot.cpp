#include "draw/pilot.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "draw/plan.h"
#include "march/march_double.h"

namespace psivox {
namespace {

/// The pilot marches one of this many of the picture's rays, within bounds. That is a small part of
/// the picture's work. Its RMS spreads by a few per cent, and its largest error is about the error
/// that one pixel in a thousand exceeds.
constexpr double rays_share = 512;
constexpr double fewest_rays = 800, most_rays = 1600;

glm::ivec2 pilot_size(const glm::ivec2& picture) {
  const glm::dvec2 size(picture);
  const double rays = std::clamp(size.x * size.y / rays_share, fewest_rays, most_rays);
  const double width = std::clamp(std::round(std::sqrt(rays * size.x / size.y)), 1.0, rays);
  return glm::min(picture, glm::ivec2(int(width), int(rays / width)));
}

View sized(View view, const glm::ivec2& size) {
  // keeps the aspect ratio to a fraction of a pixel, and the rays' positions in their pixels
  view.scene.resolution = size;
  view.scene.pixel_samples = 1;
  return view;
}

}  // namespace

View pilot_view(const View& view) { return sized(view, pilot_size(view.scene.resolution)); }

Pilot::Pilot(const View& exact, const MediumAtlas& atlas, const Progress& progress)
    : atlas_(atlas) {
  if (progress) progress_ = [progress](double) { progress(0); };
  truth_ = march({exact, {}}, pilot_size(exact.scene.resolution), exact_samples_);
}

Image Pilot::march(const MethodView& marched, const glm::ivec2& size, double& samples) const {
  RenderResult result = render_march_double(
      sized(marched.view, size), atlas_,
      {.count = true, .progress = progress_, .brick_steps = marched.brick_steps});
  samples = double(result.stats.samples) / double(result.stats.rays);
  return std::move(result.image);
}

bool Pilot::has_opacity(double opacity) const {
  const auto rgba = truth_.rgba();
  for (std::size_t i = 3; i < rgba.size(); i += 4)
    if (double(rgba[i]) > opacity) return true;
  return false;
}

double Pilot::brightest() const {
  const auto rgba = truth_.rgba();
  double most = 0;
  for (std::size_t i = 0; i < rgba.size(); ++i)
    if (i % 4 != 3) most = std::max(most, double(rgba[i]));
  return most;
}

double Pilot::rough_samples(const MethodView& marched) const {
  double samples = 0;
  march(marched, glm::min(glm::ivec2(truth_.width, truth_.height), glm::ivec2(5)), samples);
  return samples;
}

void Pilot::run(Trial& trial, const MethodView& marched) const {
  const Image image = march(marched, {truth_.width, truth_.height}, trial.samples);
  const Comparison c = compare_images(image, truth_);
  trial.rms = std::hypot(c.rms, arithmetic_error);
  trial.max = c.max;
}

}  // namespace psivox
