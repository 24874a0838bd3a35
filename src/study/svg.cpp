#include "study/svg.h"

#include "study/number_format.h"

namespace psivox {
namespace {

constexpr Ink text_ink{20, 20, 20};

std::string attribute(const char* name, double value) {
  return std::string(" ") + name + "=\"" + decimals(value, 2) + "\"";
}

}  // namespace

std::string svg(const SvgLine& l) {
  std::string out = "<line" + attribute("x1", l.x1) + attribute("y1", l.y1) +
                    attribute("x2", l.x2) + attribute("y2", l.y2) + " stroke=\"" + hex(l.ink) +
                    "\"" + attribute("stroke-width", l.width);
  if (l.dash > 0) out += attribute("stroke-dasharray", l.dash);
  return out + "/>\n";
}

std::string svg(const SvgMark& m) {
  const std::string fill = " fill=\"" + hex(m.ink) + "\"/>\n";
  switch (m.shape) {
    case Shape::disc:
      return "<circle" + attribute("cx", m.x) + attribute("cy", m.y) + attribute("r", m.radius) +
             fill;
    case Shape::ring:
      return "<circle" + attribute("cx", m.x) + attribute("cy", m.y) + attribute("r", m.radius) +
             " fill=\"none\" stroke=\"" + hex(m.ink) + "\" stroke-width=\"1.5\"/>\n";
    case Shape::square:
      return "<rect" + attribute("x", m.x - m.radius) + attribute("y", m.y - m.radius) +
             attribute("width", 2 * m.radius) + attribute("height", 2 * m.radius) + fill;
    case Shape::diamond:
      break;
  }
  const std::string x = decimals(m.x, 2), y = decimals(m.y, 2);
  return "<polygon points=\"" + x + "," + decimals(m.y - m.radius, 2) + " " +
         decimals(m.x + m.radius, 2) + "," + y + " " + x + "," + decimals(m.y + m.radius, 2) + " " +
         decimals(m.x - m.radius, 2) + "," + y + "\"" + fill;
}

std::string svg(const SvgText& t) {
  static constexpr const char* anchors[] = {"start", "middle", "end"};
  std::string out = "<text" + attribute("x", t.x) + attribute("y", t.y) + " text-anchor=\"" +
                    anchors[static_cast<int>(t.anchor)] + "\" fill=\"" + hex(text_ink) + "\"";
  if (t.upwards)
    out += " transform=\"rotate(-90 " + decimals(t.x, 2) + " " + decimals(t.y, 2) + ")\"";
  return out + ">" + escaped(t.text) + "</text>\n";
}

std::string hex(Ink ink) { return formatted("#%02x%02x%02x", ink.r, ink.g, ink.b); }

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

std::string svg_page(int width, int height, const std::string& elements) {
  const std::string w = std::to_string(width), h = std::to_string(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" +
         w + "\" height=\"" + h +
         "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" "
         "height=\"100%\" fill=\"#ffffff\"/>\n" +
         elements + "</svg>\n";
}

}  // namespace psivox
