#pragma once

#include <cstddef>
#include <glm/vec4.hpp>
#include <memory>
#include <span>
#include <vector>

#include "march/marcher.h"

namespace psivox {

/// Joins what a ray collects in the regions that it passes, front to back, and makes a picture of
/// it. What is collected has four numbers, which `collected` in shaders/modes.glsl defines for each
/// mode. Regions that follow each other may be joined first.
class RayFold {
 public:
  /// The view's light is computed.
  explicit RayFold(const View& view);

  /// What a ray has collected before its first region.
  glm::dvec4 nothing() const;

  /// Adds what lies behind: radiance weighted with the transmittance so far, and the product of
  /// transmittances (Max 1995, eq. 8); optical depths and integrals of values add up; the greater
  /// of two maxima. Adds nothing where the ray has ended.
  void add_behind(glm::dvec4& ray, const glm::dvec4& behind) const;

  /// The depth that a ray has with what lies behind, from both before they are joined: the greater
  /// maximum's, else the first. +Inf: none. A region must know which optical depths its rays have
  /// passed (RenderOptions::passed).
  float depth(const glm::dvec4& ray, float own, const glm::dvec4& behind, float others) const;

  /// Whether a ray of the whole would have ended: nothing behind is in its picture.
  bool ended(const glm::dvec4& ray) const;
  /// Whether rays end by what they have passed (RenderOptions::passed).
  bool ends_by_passed() const { return least_ > 0 || mode_ == Mode::lmip; }
  /// What a ray has passed: an optical depth, or a value.
  double passed(const glm::dvec4& ray) const;
  /// The transmittance below which rays end; 0: they do not end by it.
  double least_transmittance() const { return least_; }

  /// R G B A of a ray that has passed all regions.
  glm::dvec4 picture(const glm::dvec4& ray) const;

  /// Its transmittance; 1 in modes without.
  double transmittance(const glm::dvec4& ray) const;

 private:
  struct Maxima;
  Mode mode_;
  Shows shows_;
  double least_ = 0;
  std::shared_ptr<Maxima> maxima_;  ///< null if the mode shows no value
};

/// What rays have collected in the regions that they have passed (RayFold), for each sample of each
/// pixel of a rectangle. Samples are folded before they are averaged, because the mean of products
/// is not the product of means.
class CarriedLight {
 public:
  /// `layers` says which layers are carried beside the picture.
  CarriedLight(const RayFold& fold, const PixelBox& pixels, int samples,
               const RenderOptions& layers = {});

  const PixelBox& pixels() const { return pixels_; }
  int samples() const { return int(samples_); }
  const RayFold& fold() const { return fold_; }
  std::size_t rays() const { return rays_.size(); }
  std::size_t index(const glm::ivec2& pixel, int sample) const;

  /// Adds what rays of one sample collect in the next region. The image begins at the picture's
  /// pixel `origin`.
  void add(const Image& region, const glm::ivec2& origin, int sample);
  /// Adds what they collect in the next regions: a row of pixels that begins at `origin`.
  void add(std::span<const glm::vec4> row, const glm::ivec2& origin, int sample);
  /// A row of pixels of one sample that begins at `origin`.
  std::span<const glm::dvec4> row(const glm::ivec2& origin, int width, int sample) const;

  /// An optical depth behind which nothing is drawn.
  static constexpr float no_ray = 1e30f;
  /// Begins again with some rays, behind the optical depths of other processes' parts. The depths
  /// are by index(); rays with `no_ray` stay as they are.
  void begin_behind(std::vector<float> depths);

  /// What rays have passed (RenderOptions::passed); optical depths with those behind which they
  /// began.
  std::vector<float> passed(const PixelBox& pixels, int sample) const;

  /// Whether all rays of these pixels have ended.
  bool ended(const PixelBox& pixels) const;

  /// Means over the samples: R G B A, and the layer of transmittance if it is wanted. Then the
  /// layers that are carried, as a Film makes them: steps and samples are sums over all regions.
  Image picture(bool transmittance) const;

 private:
  /// Sums of a layer over regions and samples, pixel by pixel.
  struct Sum {
    const char* layer;
    std::vector<float> values;
  };

  double depth_before(std::size_t ray) const { return before_.empty() ? 0 : double(before_[ray]); }

  RayFold fold_;
  PixelBox pixels_;
  std::size_t samples_;
  std::vector<glm::dvec4> rays_;  ///< sample by sample, row by row
  std::vector<float> before_;     ///< see begin_behind; empty: all 0
  std::vector<float> depths_;     ///< of rays, +Inf where there is none yet; empty: not wanted
  std::vector<Sum> sums_;
};

}  // namespace psivox
