#pragma once

#include <optional>
#include <vector>

#include "gl/tile_target.h"
#include "march/film.h"

namespace psivox::gl {

/// A part of the picture in the making: one sample of each of its pixels.
struct Exposure {
  int x = 0, y = 0, width = 0, height = 0;
  int sample = 0;
  std::size_t pixels() const { return std::size_t(width) * std::size_t(height); }
};

/// Tiles on their way from the GPU to the film: read() while nothing is drawn, develop() while the
/// next tile is.
class Readback {
 public:
  /// `drawn`: number of pixels that will be read, of which options.progress tells.
  Readback(Film& film, const View& view, const RenderOptions& options, double drawn);

  /// Copies a tile from the GPU.
  void read(const TileTarget& target, const Exposure& tile);

  /// Adds pixels whose rays were not drawn.
  void add_missed(const PixelBox& pixels, const RayTexels& ray);

  /// Adds the tile that was read last, if it is not added yet, to the film, and reports it.
  void develop();

  /// Rays that stood still before their end, of what was read.
  std::uint64_t stuck() const { return stuck_; }

 private:
  void add(const Exposure& tile);
  /// The same for several samples a pixel without layers.
  void add_picture(const Exposure& tile);

  Film& film_;
  const RenderOptions& options_;
  int samples_;  ///< of a pixel
  double all_pixels_;
  std::uint64_t pixels_done_ = 0, stuck_ = 0;
  std::optional<Exposure> waiting_;
  std::vector<glm::vec4> picture_, layers_;
  std::vector<PixelSums> sums_;  ///< of the tile, where a pixel has several samples and layers
  std::vector<glm::dvec4> picture_sums_;  ///< where it has no layers
};

}  // namespace psivox::gl
