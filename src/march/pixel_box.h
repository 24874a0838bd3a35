#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/medium.h"

namespace psivox {

/// A rectangle of pixels.
struct PixelBox {
  glm::ivec2 origin{0}, size{0};
  bool empty() const { return size.x <= 0 || size.y <= 0; }
  bool operator==(const PixelBox&) const = default;
};

PixelBox common(const PixelBox& a, const PixelBox& b);

/// What is left of a rectangle without an inner one: at most four, none of them empty.
std::vector<PixelBox> around(const PixelBox& inner, const PixelBox& all);

/// Pixels of the picture whose rays may meet a box of the density's cells, and one around them, for
/// rounding.
PixelBox pixels_of(const View& view, const glm::dvec3& low, const glm::dvec3& high);
/// Pixels whose rays may meet a box of the density's bricks; all of the picture if something emits,
/// which it may do beyond the density.
PixelBox pixels_of(const View& view, const Box& bricks);

}  // namespace psivox
