#include "plan/pilot.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "march/light.h"
#include "plan/plan.h"

namespace psivox {
namespace {

/// The pilot marches one of this many of the picture's rays, within bounds. That is a small part of
/// the picture's work. Its RMS spreads by a few per cent, and its largest error is about the error
/// that one pixel in a thousand exceeds. Of small pictures it marches one ray in
/// seven, if that is fewer, but at least 400.
constexpr double rays_share = 512;
constexpr double fewest_rays = 800, most_rays = 1600;
constexpr double small_share = 7, fewest_of_small = 400;

glm::ivec2 pilot_size(const glm::ivec2& picture) {
  const glm::dvec2 size(picture);
  const double pixels = size.x * size.y;
  const double fewest = std::clamp(pixels / small_share, fewest_of_small, fewest_rays);
  const double rays = std::clamp(pixels / rays_share, fewest, most_rays);
  const double width = std::clamp(std::round(std::sqrt(rays * size.x / size.y)), 1.0, rays);
  return glm::min(picture, glm::ivec2(int(width), int(rays / width)));
}

/// The pixels of a picture, first those that a sequence of low discrepancy visits.
std::vector<int> spread_evenly(const glm::ivec2& size) {
  const std::size_t count = std::size_t(size.x) * std::size_t(size.y);
  std::vector<int> order;
  std::vector<bool> seen(count);
  const auto see = [&](int pixel) {
    if (seen[std::size_t(pixel)]) return;
    seen[std::size_t(pixel)] = true;
    order.push_back(pixel);
  };
  // powers of 1/p, where p^3 = p + 1: the plane's counterpart of the golden section
  glm::dvec2 at(0.5);
  for (std::size_t i = 0; i < 4 * count; ++i) {
    const glm::ivec2 pixel = glm::min(glm::ivec2(at * glm::dvec2(size)), size - 1);
    see(pixel.y * size.x + pixel.x);
    at = glm::fract(at + glm::dvec2(0.7548776662466927, 0.5698402909980532));
  }
  for (int pixel = 0; pixel < int(count); ++pixel) see(pixel);
  return order;
}

bool depth_alone(const Medium& medium) {
  return medium.source == LuminanceSource::constant && !medium.transfer && medium.emission.empty();
}

double cell_cost(const Medium& medium, bool paired) {
  // the function's knots cut cells into pieces; one look-up may read the luminance too
  if (medium.transfer) return paired ? 2.4 : 1.6;
  if (!medium.emission.empty()) return 1.3;
  return depth_alone(medium) ? 1.15 : 1;
}

/// Cost of a lit function's cell that is not cut at its knots: with one linear segment, and for
/// each further one.
constexpr double lit_segment_cost = 1.5, next_segment_cost = 0.65;

/// Of a cell that is one voxel: one texel is read, and one value classified.
constexpr double plain_voxel_cost = 0.75;

/// End corrections always look up slopes, needed or not.
constexpr double corrections_cost = 1.3;
constexpr double brick_steps_cost = 1.4;

double lattice_cost(const Method& method, const MethodView& marched) {
  double cost = depth_alone(marched.view.medium) ? 1 : info(method.integrator).lattice_cost;
  if (has_end_corrections(marched.view)) cost = corrections_cost;
  return marched.brick_steps ? brick_steps_cost * cost : cost;
}

}  // namespace

glm::dvec4 seen_error(const Image& truth, const Backdrop& behind, std::size_t pixel,
                      const float* rgba) {
  glm::dvec4 difference;
  for (int c = 0; c < 4; ++c)
    difference[c] = double(rgba[c]) - double(truth.rgba()[4 * pixel + std::size_t(c)]);
  return behind.seen(difference, pixel);
}

View pilot_view(const View& view) {
  // keeps the aspect ratio to a fraction of a pixel, and the rays' positions in their pixels
  View small = view;
  small.scene.resolution = pilot_size(view.scene.resolution);
  small.scene.pixel_samples = 1;
  return small;
}

Pilot::Pilot(const View& exact, const View& ended, const Backdrop& behind, const MediumAtlas& atlas,
             const Progress& progress)
    : atlas_(atlas) {
  if (progress) progress_ = [progress](double) { progress(0); };
  const glm::ivec2 size = pilot_size(exact.scene.resolution);
  behind_ = behind.reduced(size);
  order_ = spread_evenly(size);
  const std::size_t count = order_.size();
  truth_ = rgba_image(size.x, size.y);
  exact_samples_.resize(count);
  exact_errors_.resize(count);

  std::vector<MarchedRay> rays(count), sooner(count);
  const PixelMarch ending = march_of({ended, {}});
  march_of({exact, {}}).march(pixels_of(order_), rays, progress_, &ending, sooner);
  for (std::size_t i = 0; i < count; ++i) {
    const auto ray = std::size_t(order_[i]);
    for (std::size_t c = 0; c < 4; ++c)
      truth_.rgba()[4 * ray + c] = rays[i].picture[glm::length_t(c)];
    exact_samples_[ray] = rays[i].samples;
    exact_errors_[ray] = error_of(order_[i], sooner[i]);
    all_samples_ += std::uint64_t(rays[i].samples);
  }
}

int Pilot::telling_rays() const {
  const auto rgba = truth_.rgba();
  int rays = 0;
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    rays += std::any_of(&rgba[i], &rgba[i] + 4, [](float value) { return value != 0; });
  return rays;
}

double Pilot::brightest() const {
  const auto rgba = truth_.rgba();
  double most = 0;
  for (std::size_t i = 0; i < rgba.size(); ++i)
    if (i % 4 != 3) most = std::max(most, double(rgba[i]));
  return most;
}

PixelMarch Pilot::march_of(const MethodView& marched) const {
  return PixelMarch(pilot_view(marched.view), atlas_, marched.brick_steps);
}

void Pilot::march(const PixelMarch& march, std::span<const int> rays, std::span<RayError> errors) {
  std::vector<MarchedRay> marched(rays.size());
  march.march(pixels_of(rays), marched, progress_);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    errors[i] = error_of(rays[i], marched[i]);
    all_samples_ += std::uint64_t(marched[i].samples);
  }
}

std::vector<glm::ivec2> Pilot::pixels_of(std::span<const int> rays) const {
  std::vector<glm::ivec2> pixels;
  for (const int ray : rays) pixels.emplace_back(ray % truth_.width, ray / truth_.width);
  return pixels;
}

RayError Pilot::error_of(int ray, const MarchedRay& marched) const {
  RayError error{.samples = marched.samples};
  const glm::dvec4 difference = seen_error(truth_, behind_, std::size_t(ray), &marched.picture.x);
  for (int c = 0; c < 4; ++c) {
    if (!std::isfinite(difference[c])) continue;  // the device's picture tells, see confirm()
    error.squares += difference[c] * difference[c];
    error.largest = std::max(error.largest, std::abs(difference[c]));
  }
  return error;
}

View with_method(View view, const Method& method) {
  view.scene = with_method(std::move(view.scene), method);
  return view;
}

bool has_plain_voxels(const Medium& medium) {
  return medium.nearest && medium.emission.empty() && medium.others.empty() &&
         (!medium.luminance || medium.lit);
}

Method exact_method(const View& view) {
  if (has_plain_voxels(view.medium)) return {.integrator = Integrator::midpoint, .segments = 1};
  // with a gradient the attenuation along a cell is not a cubic
  if (view.medium.gradient)
    return {.integrator = Integrator::psi_exact, .segments = gradient_segments};
  // a depth alone is Simpson's rule in a segment, unless the function has knots in it
  if (!view.scene.composites() && !(view.scene.attenuates() && view.medium.transfer))
    return {.integrator = Integrator::psi_weighted, .segments = 1};
  return {.integrator = Integrator::cell_exact, .segments = 1};
}

Method lattice(const View& view, double step) {
  const bool dark = view.medium.emission.empty();
  return {.integrator = dark ? Integrator::psi_balanced : Integrator::midpoint,
          .sampling = Sampling::uniform,
          .step = step};
}

double look_up_cost(const Method& method, const MethodView& marched) {
  if (method.sampling == Sampling::uniform) return lattice_cost(method, marched);
  const Scene& scene = marched.view.scene;
  if (has_plain_voxels(marched.view.medium)) return plain_voxel_cost;
  if (marched.paired && marched.view.medium.transfer && !is_cell_rule(method.integrator) &&
      !scene.split_knots)
    return lit_segment_cost + next_segment_cost * (method.segments - 1);
  return cell_cost(marched.view.medium, marched.paired) * std::max(1.0, method.segments / 2.0);
}

}  // namespace psivox
