#pragma once

#include <cstddef>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "march/marcher.h"

namespace psivox {

/// What rays have collected in the regions that they have passed, for each sample of each pixel of
/// a rectangle: R G B, and in A the transmittance. Samples are folded before they are averaged,
/// because the mean of products is not the product of means.
class CarriedLight {
 public:
  CarriedLight(const PixelBox& pixels, int samples);

  const PixelBox& pixels() const { return pixels_; }
  int samples() const { return int(samples_); }

  /// Adds what the next region shows to rays of one sample. The image has a layer of transmittance
  /// alone, and begins at the picture's pixel `origin`.
  void add(const Image& region, const glm::ivec2& origin, int sample);
  /// Adds what the next regions show: a row of pixels of one sample, that begins at `origin`.
  void add(std::span<const glm::vec4> row, const glm::ivec2& origin, int sample);
  /// A row of pixels of one sample that begins at `origin`.
  std::span<const glm::dvec4> row(const glm::ivec2& origin, int width, int sample) const;

  /// Means over the samples: R G B A, and the layer of transmittance if it is wanted.
  Image picture(bool transmittance) const;

 private:
  std::size_t index(const glm::ivec2& pixel, int sample) const;

  PixelBox pixels_;
  std::size_t samples_;
  std::vector<glm::dvec4> rays_;  ///< sample by sample, row by row
};

/// Adds to a ray what lies behind: radiance weighted with the transmittance so far, and the product
/// of transmittances (Max 1995, eq. 8).
inline void add_behind(glm::dvec4& ray, const glm::dvec4& behind) {
  for (int c = 0; c < 3; ++c) ray[c] += ray.a * behind[c];
  ray.a *= behind.a;
}

/// Pixels whose rays may meet a region of the density, a box of bricks, and one around them, for
/// rounding.
PixelBox pixels_of(const View& view, const Box& bricks);

}  // namespace psivox
