#pragma once

#include <glm/vec4.hpp>
#include <span>

#include "march/marcher.h"

namespace psivox {

/// Depth from which on a ray counts as having none: the march writes 1e30 where the transmittance
/// never falls below 1/2.
inline constexpr double no_depth = 1e29;

/// Sums over the samples of one pixel, of what march.frag writes for each.
struct PixelSums {
  glm::dvec4 picture{0};  ///< R G B A
  glm::dvec4 layers{0};   ///< depth of those that have one, transmittance, steps, samples
  int samples = 0;
  int with_depth = 0;

  void add(const glm::dvec4& ray_picture, const glm::dvec4& ray_layers);
  /// The mean where most samples have one, else +Inf.
  float depth() const;
};

/// A picture and its layers in the making. Different pixels may be set from different threads.
class Film {
 public:
  Film(const glm::ivec2& size, int pixel_samples, const RenderOptions& layers);
  Film(const View& view, const RenderOptions& options)
      : Film(options.pixels ? options.pixels->size : view.scene.resolution,
             view.scene.pixel_samples, options) {}

  /// Picture and transmittance become means, steps and samples stay sums; depth is the mean where
  /// most samples have one, else +Inf.
  void set(int x, int y, const PixelSums& sums);

  /// R G B A of a pixel: where each has one sample it may be written there, rows `width()` apart.
  glm::vec4* pixel(int x, int y) {
    return reinterpret_cast<glm::vec4*>(picture_) + image_.index(x, y);
  }
  int width() const { return image_.width; }
  int height() const { return image_.height; }

  /// The layers of a row of pixels that have one sample each, as march.frag writes them.
  void set_layers(int x, int y, std::span<const glm::vec4> layers);
  /// Makes pixels as the one at `like` is.
  void repeat(const glm::ivec2& like, const PixelBox& pixels);
  bool has_layers() const { return image_.layers.size() > 1; }

  /// R G B A as set so far, row-major.
  const float* picture() const { return picture_; }

  /// The picture; adds its counts to `stats`.
  Image finish(RenderStats& stats);

 private:
  float* layer(const char* name, bool wanted);
  void set_layers(std::size_t i, const PixelSums& sums);

  Image image_;
  float* picture_ = nullptr;
  float* depth_ = nullptr;
  float* transmittance_ = nullptr;
  float* steps_ = nullptr;
  float* samples_ = nullptr;
  int pixel_samples_;
};

/// Draws --mode slice: the density on a plane, interpolated in double precision on the CPU, with
/// the colours of the colour map or transfer function. It takes the place of every marcher.
RenderResult draw_slice(const View& view, const RenderOptions& options);

/// The view with nothing in its medium but what a slice shows.
View slice_view(View view);

}  // namespace psivox
