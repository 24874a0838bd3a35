#pragma once

#include <cstddef>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "march/marcher.h"
#include "march/ray_fold.h"

namespace psivox {

/// What rays have collected in the regions that they have passed (RayFold), for each sample of each
/// pixel of a rectangle. Samples are folded before they are averaged, because the mean of products
/// is not the product of means.
class CarriedLight {
 public:
  /// `layers`: those of its options to carry beside the picture.
  CarriedLight(const RayFold& fold, const PixelBox& pixels, int samples,
               const RenderOptions& layers = {});

  const PixelBox& pixels() const { return pixels_; }
  int samples() const { return int(samples_); }

  /// Adds what rays of one sample collect in the next region. The image begins at the picture's
  /// pixel `origin`.
  void add(const Image& region, const glm::ivec2& origin, int sample);
  /// Adds what they collect in the next regions: a row of pixels that begins at `origin`.
  void add(std::span<const glm::vec4> row, const glm::ivec2& origin, int sample);
  /// A row of pixels of one sample that begins at `origin`.
  std::span<const glm::dvec4> row(const glm::ivec2& origin, int width, int sample) const;

  /// Optical depths that their rays have passed.
  std::vector<float> passed(const PixelBox& pixels, int sample) const;

  /// Whether no ray of these pixels sees what lies behind (RayFold::ended).
  bool ended(const PixelBox& pixels, double least) const;

  /// Means over the samples: R G B A, and the layer of transmittance if it is wanted. Then the
  /// layers that are carried, as a Film makes them: steps and samples are sums over all regions.
  Image picture(bool transmittance) const;

 private:
  /// Sums of a layer over regions and samples, pixel by pixel.
  struct Sum {
    const char* layer;
    std::vector<float> values;
  };

  std::size_t index(const glm::ivec2& pixel, int sample) const;
  std::vector<float> depths() const;

  RayFold fold_;
  PixelBox pixels_;
  std::size_t samples_;
  std::vector<glm::dvec4> rays_;  ///< sample by sample, row by row
  std::vector<float> depths_;     ///< of rays, +Inf where there is none yet; empty: not wanted
  std::vector<Sum> sums_;
};

/// Pixels whose rays may meet a region of the density, a box of bricks, and one around them, for
/// rounding.
PixelBox pixels_of(const View& view, const Box& bricks);

}  // namespace psivox
