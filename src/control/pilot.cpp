#include "control/pilot.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "psivox/renderer.h"

namespace psivox {
namespace {

/// One in so many of the picture's rays is marched by the pilot, within bounds: a small part of the
/// picture's work, and an RMS with a spread of a few per cent.
constexpr double rays_share = 512;
constexpr double fewest_rays = 400, most_rays = 1600;

glm::ivec2 pilot_size(const glm::ivec2& picture) {
  const glm::dvec2 size(picture);
  const double rays = std::clamp(size.x * size.y / rays_share, fewest_rays, most_rays);
  const double width = std::clamp(std::round(std::sqrt(rays * size.x / size.y)), 1.0, rays);
  return glm::min(picture, glm::ivec2(int(width), int(rays / width)));
}

}  // namespace

Pilot::Pilot(const View& exact, const MediumAtlas& atlas)
    : atlas_(atlas), size_(pilot_size(exact.scene.resolution)) {
  truth_ = march(exact, size_, exact_samples_);
}

int Pilot::rays() const { return size_.x * size_.y; }

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

double Pilot::rough_samples(const View& view) const {
  double samples = 0;
  march(view, glm::min(size_, glm::ivec2(5)), samples);
  return samples;
}

Image Pilot::march(const View& view, const glm::ivec2& size, double& samples) const {
  View small = view;
  // the same aspect to a part of a pixel, and the same rays' directions within it
  small.scene.resolution = size;
  small.scene.pixel_samples = 1;
  RenderResult result = render_march_double(small, atlas_, {.count = true});
  samples = double(result.stats.samples) / double(result.stats.rays);
  return std::move(result.image);
}

void Pilot::run(Trial& way, const View& view) const {
  const Comparison c = compare_images(march(view, size_, way.samples), truth_);
  way.rms = std::hypot(c.rms, arithmetic_error);
  way.max = c.max;
}

}  // namespace psivox
