#include "plan/pilot.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

#include "plan/picture_error.h"

namespace psivox {
namespace {

/// The pilot marches one of this many of the picture's rays, within bounds. That is a small part of
/// the picture's work. Its RMS spreads by a few per cent, and its largest error is about the error
/// that one pixel in a thousand exceeds. Of small pictures it marches one ray in
/// seven, if that is fewer, but at least 400.
constexpr double rays_share = 512;
constexpr double fewest_rays = 800, most_rays = 1600;
constexpr double small_share = 7, fewest_of_small = 400;

/// Rays that are marched before what they miss is looked at. Then as many again are marched.
constexpr std::size_t first_rays = 24;

/// The truth's rays end at this fraction of the transmittance at which the picture's rays end.
constexpr double truth_termination = 1.0 / 64;

/// Radiance that is to be expected of a ray, relative to the brightest ray of the pilot.
constexpr double brightness_share = 2;

glm::ivec2 pilot_size(const glm::ivec2& picture) {
  const glm::dvec2 size(picture);
  const double pixels = size.x * size.y;
  const double fewest = std::clamp(pixels / small_share, fewest_of_small, fewest_rays);
  return rays_over(picture, std::clamp(pixels / rays_share, fewest, most_rays));
}

/// The view by the truth's method: the exact one, or twice its segments where these miss something.
View exactly(const View& view, double termination) {
  Method method = exact_method(view);
  if (view.medium.gradient) method.segments *= 2;
  View exact = with_method(view, method);
  *exact.scene.early_termination *= termination;
  return exact;
}

float radiance_of(const glm::vec4& rgba) { return std::max({rgba.x, rgba.y, rgba.z}); }

}  // namespace

glm::ivec2 rays_over(const glm::ivec2& picture, double count) {
  const double width = std::clamp(std::round(std::sqrt(count * picture.x / picture.y)), 1.0, count);
  return glm::clamp(glm::ivec2(int(width), int(count / width)), glm::ivec2(1), picture);
}

View pilot_view(const View& view) {
  // keeps the aspect ratio to a fraction of a pixel, and the rays' positions in their pixels
  View small = view;
  small.scene.resolution = pilot_size(view.scene.resolution);
  small.scene.pixel_samples = 1;
  return small;
}

Pilot::Pilot(const View& view, const Backdrop& behind, const MediumAtlas& atlas,
             const Progress& progress) {
  const glm::ivec2 size = pilot_size(view.scene.resolution);
  behind_ = behind.reduced(size);
  pixels_ = spread_pixels(size, SIZE_MAX);
  truth_ = rgba_image(size.x, size.y);
  exact_samples_.resize(pixels_.size());
  exact_errors_.all_rays = pixels_.size();

  const View truth = exactly(view, truth_termination);
  std::vector<MarchedRay> rays(pixels_.size()), sooner(pixels_.size());
  const PixelMarch ending(pilot_view(exactly(view, 1)), atlas);
  PixelMarch(pilot_view(truth), atlas).march(pixels_, rays, progress, &ending, sooner);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const std::size_t at = truth_.index(pixels_[i].x, pixels_[i].y);
    std::copy_n(&rays[i].picture.x, 4, &truth_.rgba()[4 * at]);
    exact_samples_[at] = rays[i].samples;
    exact_errors_.all_exact += rays[i].samples;
  }
  for (std::size_t i = 0; i < rays.size(); ++i) add(exact_errors_, pixels_[i], sooner[i]);
  all_samples_ = std::uint64_t(exact_errors_.all_exact);

  const std::vector<glm::ivec2> glowing = glowing_pixels(view, atlas);
  rays.resize(glowing.size());
  if (!glowing.empty()) PixelMarch(truth, atlas).march(glowing, rays, progress);
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (double(radiance_of(rays[i].picture)) > brightest())
      unmet_.push_back({glowing[i], rays[i].picture});
}

int Pilot::telling_rays() const {
  return int(std::ranges::count_if(pixels_, [&](const glm::ivec2& pixel) {
    const float* rgba = &truth_.rgba()[4 * truth_.index(pixel.x, pixel.y)];
    return std::any_of(rgba, rgba + 4, [](float value) { return value != 0; });
  }));
}

double Pilot::brightest() const {
  const auto rgba = truth_.rgba();
  float most = 0;
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    most = std::max(most, radiance_of({rgba[i], rgba[i + 1], rgba[i + 2], 0}));
  return brightness_share * double(most);
}

RayErrors Pilot::march(const MethodView& marched, const MediumAtlas& atlas,
                       const Progress& progress, const GoOn& go_on, const BrickCodes* codes) {
  const PixelMarch march(pilot_view(marched.view), atlas, marched.brick_steps, codes);
  RayErrors errors{.all_rays = pixels_.size(), .all_exact = exact_errors_.all_exact};
  std::vector<MarchedRay> rays(pixels_.size());
  do {
    const std::size_t some = std::min(std::max(first_rays, errors.rays), rays.size() - errors.rays);
    const auto pixels = std::span(pixels_).subspan(errors.rays, some);
    march.march(pixels, std::span(rays).first(some), progress);
    for (std::size_t i = 0; i < some; ++i) {
      add(errors, pixels[i], rays[i]);
      all_samples_ += std::uint64_t(rays[i].samples);
    }
  } while (go_on(errors) && errors.rays < errors.all_rays);
  // it shows soonest that the next method fails too
  std::rotate(pixels_.begin(), pixels_.begin() + std::ptrdiff_t(errors.worst),
              pixels_.begin() + std::ptrdiff_t(errors.worst) + 1);
  return errors;
}

void Pilot::add(RayErrors& errors, const glm::ivec2& pixel, const MarchedRay& ray) const {
  const std::size_t at = truth_.index(pixel.x, pixel.y);
  ++errors.rays;
  errors.samples += ray.samples;
  errors.exact_samples += exact_samples_[at];
  const glm::dvec4 difference = seen_error(truth_, behind_, at, &ray.picture.x);
  for (int c = 0; c < 4; ++c) {
    if (!std::isfinite(difference[c])) continue;  // the device's picture tells, see confirm()
    errors.squares += difference[c] * difference[c];
    if (std::abs(difference[c]) > errors.max) {
      errors.max = std::abs(difference[c]);
      errors.worst = errors.rays - 1;
    }
  }
}

}  // namespace psivox
