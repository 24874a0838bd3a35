#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "psivox/image.h"

namespace psivox {

/// An sRGB colour.
struct Ink {
  std::uint8_t r = 0, g = 0, b = 0;
};

/// Lines, marks and text on a white page; x to the right, y downwards, in units of a pixel.
struct Drawing {
  struct Line {
    double x1, y1, x2, y2, width;
    Ink ink;
    double dash = 0;  ///< length of a dash and of the gap after it; 0: solid
  };
  enum class Shape { disc, square, diamond, ring };
  struct Mark {
    double x, y, radius;
    Shape shape;
    Ink ink;
  };
  enum class Anchor { start, middle, end };
  struct Text {
    double x, y;       ///< of the anchor on the base line
    std::string text;  ///< ASCII
    Anchor anchor = Anchor::start;
    bool upwards = false;  ///< reads from below to above
    Ink ink = {};
  };

  int width = 0, height = 0;
  std::vector<std::variant<Line, Mark, Text>> items;  ///< later ones cover earlier ones
};

/// The same drawing as SVG, and as an opaque picture of `scale` pixels a unit.
std::string svg_of(const Drawing& drawing);
Image picture_of(const Drawing& drawing, int scale = 2);

/// `text` with &, < and > as HTML and SVG want them.
std::string escaped(const std::string& text);

}  // namespace psivox
