#include "march/film.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace psivox {

void PixelSums::add(const glm::dvec4& ray_picture, const glm::dvec4& ray_layers) {
  picture += ray_picture;
  layers += glm::dvec4(ray_layers.x < no_depth ? ray_layers.x : 0.0, ray_layers.y, ray_layers.z,
                       ray_layers.w);
  with_depth += ray_layers.x < no_depth;
  ++samples;
}

float PixelSums::depth() const {
  return 2 * with_depth > samples ? float(layers.x / with_depth)
                                  : std::numeric_limits<float>::infinity();
}

Film::Film(const glm::ivec2& size, int pixel_samples, const RenderOptions& options)
    : image_(rgba_image(size.x, size.y)), pixel_samples_(pixel_samples) {
  image_.layers.reserve(5);  // the pointers into them must stay
  picture_ = image_.layers[0].values.data();
  depth_ = layer("depth", options.depth);
  transmittance_ = layer("transmittance", options.transmittance);
  steps_ = layer("steps", options.count);
  samples_ = layer("samples", options.count);
}

float* Film::layer(const char* name, bool wanted) {
  if (!wanted) return nullptr;
  image_.layers.push_back({name, {name}, std::vector<float>(image_.pixels())});
  return image_.layers.back().values.data();
}

void Film::set(int x, int y, const PixelSums& sums) {
  *pixel(x, y) = glm::vec4(sums.picture / double(sums.samples));
  set_layers(image_.index(x, y), sums);
}

void Film::repeat(const glm::ivec2& like, const PixelBox& pixels) {
  for (Layer& layer : image_.layers) {
    const std::size_t channels = layer.channels.size();
    const float* const from = layer.values.data() + image_.index(like.x, like.y) * channels;
    for (int y = 0; y < pixels.size.y; ++y) {
      float* to =
          layer.values.data() + image_.index(pixels.origin.x, pixels.origin.y + y) * channels;
      for (int x = 0; x < pixels.size.x; ++x) to = std::copy_n(from, channels, to);
    }
  }
}

void Film::set_layers(int x, int y, std::span<const glm::vec4> layers) {
  for (std::size_t k = 0; k < layers.size(); ++k) {
    PixelSums sums;
    sums.add(glm::dvec4(0), glm::dvec4(layers[k]));
    set_layers(image_.index(x, y) + k, sums);
  }
}

void Film::set_layers(std::size_t i, const PixelSums& sums) {
  if (depth_) depth_[i] = sums.depth();
  if (transmittance_) transmittance_[i] = float(sums.layers.y / sums.samples);
  if (steps_) steps_[i] = float(sums.layers.z);
  if (samples_) samples_[i] = float(sums.layers.w);
}

Image Film::finish(RenderStats& stats) {
  const auto pixels = std::uint64_t(image_.width) * std::uint64_t(image_.height);
  stats.rays += pixels * std::uint64_t(pixel_samples_);
  if (steps_) stats.steps += std::uint64_t(std::accumulate(steps_, steps_ + pixels, 0.0));
  if (samples_) stats.samples += std::uint64_t(std::accumulate(samples_, samples_ + pixels, 0.0));
  return std::move(image_);
}

}  // namespace psivox
