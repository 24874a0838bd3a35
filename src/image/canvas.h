#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/image.h"

namespace psivox::image_io {

/// DejaVu Sans as a TrueType file; empty if psivox was built without.
const std::map<std::string, std::string>& embedded_font();

/// One line of text as coverage, 0 to 1, row by row from the top.
struct TextPicture {
  int width = 0, height = 0;
  std::vector<float> coverage;
};

/// The text in DejaVu Sans, which the library contains, so that a machine needs no fonts. All
/// pictures of one size have the same height and baseline.
///
/// `size`: from the top of ascenders to the bottom of descenders [pixels].
TextPicture text_picture(std::string_view text, double size);

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
  /// Radiance that the display shows as this light.
  glm::dvec3 shown(const glm::dvec3& light) const;

  void fill(const Rectangle& r, const glm::dvec3& color);
  void write(const TextPicture& text, int x, int y, const glm::dvec3& color);
  /// A line between two points [pixels]. `under`: below what the picture has, which is not opaque.
  void line(const glm::dvec2& from, const glm::dvec2& to, double thick, const glm::dvec3& color,
            bool under = false);

 private:
  glm::dvec3 shown(double light) const { return shown(glm::dvec3(light)); }
  void set(int x, int y, const glm::dvec3& color, double coverage, bool under = false);

  Image& image_;
  Display display_;
};

/// The text in that size, or smaller where it is wider than the room.
TextPicture fitted(const std::string& text, double size, int room);

}  // namespace psivox::image_io
