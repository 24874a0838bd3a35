#pragma once

#include <glm/vec3.hpp>
#include <string>

#include "glyphs.h"
#include "psivox/display.h"
#include "psivox/image.h"

namespace psivox::image_io {

struct Rectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Draws opaque colours on a picture whose codes a display will show.
class Canvas {
 public:
  Canvas(Image& image, const Display& display) : image_(image), display_(display) {}

  /// Radiance that the display shows as the white of texts, and as the dark ground behind them.
  glm::dvec3 white() const { return shown(0.9); }
  glm::dvec3 ground() const { return shown(0.015); }

  void fill(const Rectangle& r, const glm::dvec3& color);
  void write(const TextPicture& text, int x, int y, const glm::dvec3& color);

 private:
  glm::dvec3 shown(double light) const;
  void set(int x, int y, const glm::dvec3& color, double coverage);

  Image& image_;
  Display display_;
};

/// The text in that size, or smaller where it is wider than the room.
TextPicture fitted(const std::string& text, double size, int room);

}  // namespace psivox::image_io
