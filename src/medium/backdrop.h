#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace psivox {

struct View;

/// What a picture shows behind the medium: its scene's background, or black.
class Backdrop {
 public:
  Backdrop() = default;
  /// Behind the centres of the view's pixels. Its environment must have been read.
  explicit Backdrop(const View& view);
  /// For a smaller picture of the same view: a pixel has the root mean square over those of this
  /// one for which it stands. A sun that lies between its pixels counts by its share of them.
  Backdrop reduced(const glm::ivec2& size) const;

  /// Radiance by pixels; empty if it is the same behind all.
  const std::vector<glm::vec3>& pixels() const { return pixels_; }
  glm::dvec3 at(std::size_t pixel) const {
    return pixels_.empty() ? color_ : glm::dvec3(pixels_[pixel]);
  }
  /// The greatest radiance of any channel and pixel; of a smaller picture, of all it stands for.
  double greatest() const { return greatest_; }
  /// The difference of a pixel's R G B A as it is seen: where the medium covers less, more of what
  /// is behind it shows.
  glm::dvec4 seen(const glm::dvec4& difference, std::size_t pixel) const {
    return {glm::dvec3(difference) - difference.w * at(pixel), difference.w};
  }

 private:
  glm::dvec3 color_{0};
  glm::ivec2 size_{0};
  std::vector<glm::vec3> pixels_;
  double greatest_ = 0;
};

}  // namespace psivox
