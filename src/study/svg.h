#pragma once

#include <cstdint>
#include <string>

// Elements of an SVG: x to the right, y downwards, in pixels.

namespace psivox {

/// An sRGB colour.
struct Ink {
  std::uint8_t r = 0, g = 0, b = 0;
};
/// "#1f77b4", as HTML and SVG write it.
std::string hex(Ink ink);

/// `text` with &, < and > escaped for HTML and SVG.
std::string escaped(const std::string& text);

struct SvgLine {
  double x1, y1, x2, y2, width;
  Ink ink;
  double dash = 0;  ///< length of a dash and of the gap after it; 0: solid
};
std::string svg(const SvgLine& line);

enum class Shape { disc, square, diamond, ring };
struct SvgMark {
  double x, y, radius;
  Shape shape;
  Ink ink;
};
std::string svg(const SvgMark& mark);

enum class Anchor { start, middle, end };
struct SvgText {
  double x, y;  ///< of the anchor on the base line
  std::string text;
  Anchor anchor = Anchor::start;
  bool upwards = false;  ///< reads from bottom to top
};
std::string svg(const SvgText& text);

/// The elements on a white page. Later ones cover earlier ones.
std::string svg_page(int width, int height, const std::string& elements);

}  // namespace psivox
