#include "draw/carried_light.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <string>
#include <string_view>

#include "march/film.h"
#include "psivox/error.h"

namespace psivox {

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

std::vector<float> CarriedLight::passed(const PixelBox& pixels, int sample) const {
  constexpr double least = 1e-30;  // behind half of the light, where it does not matter
  std::vector<float> depths;
  for (int y = 0; y < pixels.size.y; ++y)
    for (const glm::dvec4& ray : row(pixels.origin + glm::ivec2(0, y), pixels.size.x, sample))
      depths.push_back(float(-std::log(std::max(fold_.transmittance(ray), least))));
  return depths;
}

bool CarriedLight::ended(const PixelBox& pixels, double least) const {
  for (int sample = 0; sample < samples(); ++sample)
    for (int y = 0; y < pixels.size.y; ++y)
      for (const glm::dvec4& ray : row(pixels.origin + glm::ivec2(0, y), pixels.size.x, sample))
        if (!fold_.ended(ray, least)) return false;
  return true;
}

std::vector<float> CarriedLight::depths() const {
  const std::size_t pixels = rays_.size() / samples_;
  std::vector<float> means(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    PixelSums sums;
    for (std::size_t sample = 0; sample < samples_; ++sample)
      sums.add(glm::dvec4(0), {depths_[sample * pixels + i], 0, 0, 0});
    means[i] = sums.depth();
  }
  return means;
}

Image CarriedLight::picture(bool transmittance) const {
  const std::size_t pixels = rays_.size() / samples_;
  Image image{pixels_.size.x,
              pixels_.size.y,
              {{"", {"R", "G", "B", "A"}, std::vector<float>(4 * pixels)}},
              {}};
  std::vector<float> left(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    glm::dvec4 sum(0);
    double through = 0;
    for (std::size_t sample = 0; sample < samples_; ++sample) {
      const glm::dvec4& ray = rays_[sample * pixels + i];
      sum += fold_.picture(ray);
      through += fold_.transmittance(ray);
    }
    for (int c = 0; c < 4; ++c)
      image.rgba()[4 * i + std::size_t(c)] = float(sum[c] / double(samples_));
    left[i] = float(through / double(samples_));
  }
  if (!depths_.empty()) image.layers.push_back({"depth", {"depth"}, depths()});
  if (transmittance) image.layers.push_back({"transmittance", {"transmittance"}, std::move(left)});
  for (const Sum& sum : sums_) image.layers.push_back({sum.layer, {sum.layer}, sum.values});
  return image;
}

PixelBox pixels_of(const View& view, const Box& bricks) {
  const PixelBox all{{}, view.scene.resolution};
  const Field& density = *view.medium.density;
  if (view.medium.emission) return all;  // it may reach beyond the density
  const Box domain = density.domain();
  const glm::dvec3 low = glm::max(8.0 * glm::dvec3(bricks.min), glm::dvec3(domain.min));
  const glm::dvec3 high = glm::min(8.0 * glm::dvec3(bricks.max) + 8.0, glm::dvec3(domain.max));
  return pixels_of(view, low, high);
}

}  // namespace psivox
