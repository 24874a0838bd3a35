#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace psivox {

/// An sRGB colour.
struct Ink {
  std::uint8_t r = 0, g = 0, b = 0;
};
/// "#1f77b4", as HTML and SVG write it.
std::string hex(Ink ink);

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
    bool upwards = false;  ///< reads from bottom to top
    Ink ink = {};
  };

  int width = 0, height = 0;
  std::vector<std::variant<Line, Mark, Text>> items;  ///< later ones cover earlier ones
};

/// The drawing as SVG.
std::string svg_of(const Drawing& drawing);

/// `text` with &, < and > escaped for HTML and SVG.
std::string escaped(const std::string& text);

}  // namespace psivox
