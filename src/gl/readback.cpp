#include "gl/readback.h"

#include <span>

#include "march/shader_constants.h"

namespace psivox::gl {

Readback::Readback(Film& film, const View& view, const RenderOptions& options, double drawn)
    : film_(film), options_(options), samples_(view.scene.pixel_samples), all_pixels_(drawn) {}

void Readback::read(const TileTarget& target, const Exposure& tile) {
  waiting_ = tile;
  glm::vec4* pixels = film_.pixel(tile.x, tile.y);
  int stride = film_.width();
  if (samples_ > 1) {
    picture_.resize(tile.pixels());
    pixels = picture_.data();
    stride = tile.width;
  }
  target.read_picture(tile.width, tile.height, pixels, stride);
  for (int row = 0; row < tile.height; ++row)
    for (glm::vec4& pixel :
         std::span(pixels + std::ptrdiff_t(row) * stride, std::size_t(tile.width)))
      if (pixel.w > 0.5f * float(stuck_mark)) {
        pixel.w -= float(stuck_mark);
        ++stuck_;
      }
  if (!film_.has_layers()) return;
  layers_.resize(tile.pixels());
  target.read_layers(tile.width, tile.height, layers_.data(), tile.width);
}

void Readback::develop() {
  if (!waiting_) return;
  const Exposure tile = *waiting_;
  waiting_.reset();
  add(tile);
  if (tile.sample + 1 < samples_) return;
  pixels_done_ += tile.pixels();
  if (options_.tile) options_.tile({tile.x, tile.y, tile.width, tile.height, film_.picture()});
  if (options_.progress) options_.progress(double(pixels_done_) / all_pixels_);
}

void Readback::add_missed(const PixelBox& pixels, const RayTexels& ray) {
  PixelSums sums;
  for (int i = 0; i < samples_; ++i) sums.add(glm::dvec4(ray.picture), glm::dvec4(ray.layers));
  const auto& [origin, size] = pixels;
  if (film_.has_layers() || ray.picture != glm::vec4(0))  // with which a film begins
    for (int y = origin.y; y < origin.y + size.y; ++y)
      for (int x = origin.x; x < origin.x + size.x; ++x) film_.set(x, y, sums);
  if (options_.tile) options_.tile({origin.x, origin.y, size.x, size.y, film_.picture()});
}

void Readback::add(const Exposure& tile) {
  if (samples_ == 1) {
    const std::span<const glm::vec4> layers = layers_;
    const auto width = std::size_t(tile.width);
    for (int row = 0; film_.has_layers() && row < tile.height; ++row)
      film_.set_layers(tile.x, tile.y + row, layers.subspan(std::size_t(row) * width, width));
    return;
  }
  if (!film_.has_layers()) return add_picture(tile);
  if (tile.sample == 0) sums_.assign(tile.pixels(), {});
  std::size_t k = 0;
  for (int y = tile.y; y < tile.y + tile.height; ++y)
    for (int x = tile.x; x < tile.x + tile.width; ++x, ++k) {
      sums_[k].add(glm::dvec4(picture_[k]), glm::dvec4(layers_[k]));
      if (tile.sample + 1 == samples_) film_.set(x, y, sums_[k]);
    }
}

void Readback::add_picture(const Exposure& tile) {
  picture_sums_.resize(tile.pixels());
  const bool first = tile.sample == 0, last = tile.sample + 1 == samples_;
  const auto width = std::size_t(tile.width);
  for (int row = 0; row < tile.height; ++row) {
    const std::size_t from = std::size_t(row) * width;
    glm::vec4* pixels = film_.pixel(tile.x, tile.y + row);
    for (std::size_t i = 0; i < width; ++i) {
      glm::dvec4 sum(picture_[from + i]);
      if (!first) sum += picture_sums_[from + i];
      if (last)
        pixels[i] = glm::vec4(sum / double(samples_));
      else
        picture_sums_[from + i] = sum;
    }
  }
}

}  // namespace psivox::gl
