#include "march/carried_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <string>
#include <string_view>

#include "march/atlas_march.h"
#include "march/film.h"
#include "psivox/error.h"

namespace psivox {

/// The march without an atlas, for what it shows of maxima.
struct RayFold::Maxima {
  explicit Maxima(const View& view) : setup(make_march_setup(view, none)), march(setup, none) {}

  glm::dvec4 picture(const glm::dvec4& collected, Mode mode) {
    glsl::AtlasMarch::March ray{};
    constexpr double rounding = 1e-5;  // of the sum of pieces in float32
    ray.radiance = {collected.x, collected.z, collected.y};
    // 0 is the least value of what is not stored
    if (mode == Mode::minip && collected.z - collected.y > rounding * collected.z)
      ray.radiance.x = std::max(ray.radiance.x, 0.0);
    return march.picture(ray, {});
  }

  const MediumAtlas none{};
  const MarchSetup setup;
  glsl::AtlasMarch march;
};

RayFold::RayFold(const View& view) : mode_(view.scene.mode), shows_(info(mode_).shows) {
  if (shows_ == Shows::value) maxima_ = std::make_shared<Maxima>(view);
  if (shows_ == Shows::light) least_ = view.scene.resolved_early_termination();
}

glm::dvec4 RayFold::nothing() const {
  if (!maxima_) return {0, 0, 0, 1};
  return {mode_ == Mode::mean ? 0 : maxima_->march.UNKNOWN, 0, 0, 0};
}

void RayFold::add_behind(glm::dvec4& ray, const glm::dvec4& behind) const {
  if (ended(ray)) return;
  if (mode_ == Mode::minip || mode_ == Mode::mean) {
    ray = {mode_ == Mode::mean ? ray.x + behind.x : std::max(ray.x, behind.x), ray.y + behind.y,
           std::max(ray.z, behind.z), 0};
    return;
  }
  if (maxima_) {
    ray = {std::max(ray.x, behind.x), behind.y, 0, 0};
    return;
  }
  const double weight = shows_ == Shows::depth ? 1 : ray.a;
  for (int c = 0; c < 3; ++c) ray[c] += weight * behind[c];
  ray.a *= behind.a;
}

float RayFold::depth(const glm::dvec4& ray, float own, const glm::dvec4& behind,
                     float others) const {
  if (maxima_) return !ended(ray) && behind.x > ray.x ? others : own;
  return std::isfinite(own) ? own : others;
}

bool RayFold::ended(const glm::dvec4& ray) const {
  if (maxima_) return mode_ == Mode::lmip && ray.y > 0;
  return shows_ != Shows::depth && ray.a <= least_;
}

glm::dvec4 RayFold::picture(const glm::dvec4& ray) const {
  if (maxima_) return maxima_->picture(ray, mode_);
  return {glm::dvec3(ray), 1 - ray.a};
}

double RayFold::passed(const glm::dvec4& ray) const {
  constexpr double least = 1e-38;
  return maxima_ ? ray.x : -std::log(std::max(ray.a, least));
}

double RayFold::transmittance(const glm::dvec4& ray) const {
  return maxima_ || shows_ == Shows::surface ? 1 : ray.a;
}

namespace {

constexpr float none = std::numeric_limits<float>::infinity();

/// The layer's values, of which each pixel has one.
const float* layer_of(const Image& image, std::string_view name) {
  for (const Layer& layer : image.layers)
    if (layer.name == name) return layer.values.data();
  throw Error(ExitCode::failure, "a region has no layer " + std::string(name));
}

}  // namespace

CarriedLight::CarriedLight(const RayFold& fold, const PixelBox& pixels, int samples,
                           const RenderOptions& layers)
    : fold_(fold),
      pixels_(pixels.empty() ? PixelBox{} : pixels),
      samples_(std::size_t(samples)),
      rays_(samples_ * std::size_t(pixels_.size.x) * std::size_t(pixels_.size.y), fold.nothing()) {
  if (layers.depth) depths_.assign(rays_.size(), none);
  if (layers.count)
    for (const char* layer : {"steps", "samples"})
      sums_.push_back({layer, std::vector<float>(rays_.size() / samples_)});
}

std::size_t CarriedLight::index(const glm::ivec2& pixel, int sample) const {
  const glm::ivec2 at = pixel - pixels_.origin;
  const auto row = std::size_t(sample) * std::size_t(pixels_.size.y) + std::size_t(at.y);
  return row * std::size_t(pixels_.size.x) + std::size_t(at.x);
}

void CarriedLight::add(const Image& region, const glm::ivec2& origin, int sample) {
  const float* collected = region.rgba().data();
  const float* depth = depths_.empty() ? nullptr : layer_of(region, "depth");
  for (int y = 0; y < region.height; ++y) {
    std::size_t ray = index(origin + glm::ivec2(0, y), sample);
    for (int x = 0; x < region.width; ++x, ++ray, collected += 4) {
      const glm::dvec4 behind(collected[0], collected[1], collected[2], collected[3]);
      if (depth) depths_[ray] = fold_.depth(rays_[ray], depths_[ray], behind, *depth++);
      fold_.add_behind(rays_[ray], behind);
    }
  }
  for (Sum& sum : sums_) {
    const float* part = layer_of(region, sum.layer);
    for (int y = 0; y < region.height; ++y) {
      float* pixel = sum.values.data() + index(origin + glm::ivec2(0, y), 0);
      for (int x = 0; x < region.width; ++x) *pixel++ += *part++;
    }
  }
}

void CarriedLight::add(std::span<const glm::vec4> row, const glm::ivec2& origin, int sample) {
  glm::dvec4* ray = rays_.data() + index(origin, sample);
  for (const glm::vec4& behind : row) fold_.add_behind(*ray++, glm::dvec4(behind));
}

std::span<const glm::dvec4> CarriedLight::row(const glm::ivec2& origin, int width,
                                              int sample) const {
  return std::span(rays_).subspan(index(origin, sample), std::size_t(width));
}

void CarriedLight::begin_behind(std::vector<float> depths) {
  before_ = std::move(depths);
  for (std::size_t i = 0; i < rays_.size(); ++i)
    if (before_[i] < no_ray) rays_[i] = fold_.nothing();
}

std::vector<float> CarriedLight::passed(const PixelBox& pixels, int sample) const {
  std::vector<float> found;
  found.reserve(std::size_t(pixels.size.x) * std::size_t(pixels.size.y));
  for (int y = 0; y < pixels.size.y; ++y) {
    const std::size_t first = index(pixels.origin + glm::ivec2(0, y), sample);
    for (std::size_t i = first; i < first + std::size_t(pixels.size.x); ++i)
      found.push_back(float(depth_before(i) + fold_.passed(rays_[i])));
  }
  return found;
}

bool CarriedLight::ended(const PixelBox& pixels) const {
  for (int sample = 0; sample < samples(); ++sample)
    for (int y = 0; y < pixels.size.y; ++y) {
      const std::size_t first = index(pixels.origin + glm::ivec2(0, y), sample);
      for (std::size_t i = first; i < first + std::size_t(pixels.size.x); ++i)
        if (!fold_.ended(rays_[i]) && depth_before(i) < double(no_ray)) return false;
    }
  return true;
}

Image CarriedLight::picture(bool transmittance) const {
  Film film(pixels_.size, samples(), {.depth = !depths_.empty(), .transmittance = transmittance});
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x) {
      PixelSums sums;
      for (int sample = 0; sample < samples(); ++sample) {
        const std::size_t i = index(pixels_.origin + glm::ivec2(x, y), sample);
        sums.add(fold_.picture(rays_[i]),
                 {depths_.empty() ? none : depths_[i], fold_.transmittance(rays_[i]), 0, 0});
      }
      film.set(x, y, sums);
    }
  RenderStats stats;
  Image image = film.finish(stats);
  for (const Sum& sum : sums_) image.layers.push_back({sum.layer, {sum.layer}, sum.values});
  return image;
}

}  // namespace psivox
