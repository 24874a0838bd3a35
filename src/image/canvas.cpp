#include "canvas.h"

#include <cmath>
#include <cstddef>

#include "colour/display.h"

namespace psivox::image_io {

glm::dvec3 Canvas::shown(double light) const {
  return glm::dvec3(radiance_of_display(light, display_.tone_map) / display_.factor());
}

void Canvas::fill(const Rectangle& r, const glm::dvec3& color) {
  for (int y = r.y; y < r.y + r.height; ++y)
    for (int x = r.x; x < r.x + r.width; ++x) set(x, y, color, 1);
}

void Canvas::write(const TextPicture& text, int x, int y, const glm::dvec3& color) {
  for (int row = 0; row < text.height; ++row)
    for (int column = 0; column < text.width; ++column)
      set(x + column, y + row, color,
          double(text.coverage[std::size_t(row * text.width + column)]));
}

void Canvas::set(int x, int y, const glm::dvec3& color, double coverage) {
  if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return;
  float* const pixel =
      &image_.rgba()[4 * (std::size_t(y) * std::size_t(image_.width) + std::size_t(x))];
  for (int c = 0; c < 3; ++c) pixel[c] = float(std::lerp(double(pixel[c]), color[c], coverage));
  pixel[3] = float(std::lerp(double(pixel[3]), 1.0, coverage));
}

TextPicture fitted(const std::string& text, double size, int room) {
  const TextPicture picture = text_picture(text, size);
  return picture.width <= room ? picture : text_picture(text, size * room / picture.width);
}

}  // namespace psivox::image_io
