#include "medium/backdrop.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "psivox/medium.h"
#include "scene/environment.h"

namespace psivox {

Backdrop::Backdrop(const View& view) : size_(view.scene.resolution) {
  if (!view.scene.background) return;
  color_ = view.scene.background->color;
  greatest_ = std::max({color_.x, color_.y, color_.z});
  if (!view.scene.background->environment || !view.environment) return;
  for (int y = 0; y < size_.y; ++y)
    for (int x = 0; x < size_.x; ++x) {
      const glm::vec3 radiance(
          view.environment->at(camera_ray(view.camera, size_, x + 0.5, y + 0.5).direction));
      pixels_.push_back(radiance);
      greatest_ = std::max({greatest_, double(radiance.x), double(radiance.y), double(radiance.z)});
    }
}

Backdrop Backdrop::reduced(const glm::ivec2& size) const {
  Backdrop small = *this;
  small.size_ = size;
  if (pixels_.empty()) return small;
  std::vector<glm::dvec3> squares(std::size_t(size.x) * std::size_t(size.y));
  std::vector<double> counts(squares.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const glm::ivec2 pixel(int(i % std::size_t(size_.x)), int(i / std::size_t(size_.x)));
    const glm::ivec2 part = pixel * size / size_;
    const std::size_t at = std::size_t(part.y) * std::size_t(size.x) + std::size_t(part.x);
    squares[at] += glm::dvec3(pixels_[i]) * glm::dvec3(pixels_[i]);
    ++counts[at];
  }
  small.pixels_.resize(squares.size());
  for (std::size_t i = 0; i < squares.size(); ++i)
    small.pixels_[i] = glm::sqrt(squares[i] / counts[i]);
  return small;
}

}  // namespace psivox
