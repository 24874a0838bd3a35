#include "study/drawing.h"
#include "study/number_format.h"

namespace psivox {
namespace {

std::string attribute(const char* name, double value) {
  return std::string(" ") + name + "=\"" + decimals(value, 2) + "\"";
}

std::string element(const Drawing::Line& l) {
  std::string out = "<line" + attribute("x1", l.x1) + attribute("y1", l.y1) +
                    attribute("x2", l.x2) + attribute("y2", l.y2) + " stroke=\"" + hex(l.ink) +
                    "\"" + attribute("stroke-width", l.width);
  if (l.dash > 0) out += attribute("stroke-dasharray", l.dash);
  return out + "/>\n";
}

std::string element(const Drawing::Mark& m) {
  const std::string fill = " fill=\"" + hex(m.ink) + "\"/>\n";
  switch (m.shape) {
    case Drawing::Shape::disc:
      return "<circle" + attribute("cx", m.x) + attribute("cy", m.y) + attribute("r", m.radius) +
             fill;
    case Drawing::Shape::ring:
      return "<circle" + attribute("cx", m.x) + attribute("cy", m.y) + attribute("r", m.radius) +
             " fill=\"none\" stroke=\"" + hex(m.ink) + "\" stroke-width=\"1.5\"/>\n";
    case Drawing::Shape::square:
      return "<rect" + attribute("x", m.x - m.radius) + attribute("y", m.y - m.radius) +
             attribute("width", 2 * m.radius) + attribute("height", 2 * m.radius) + fill;
    case Drawing::Shape::diamond:
      break;
  }
  const std::string x = decimals(m.x, 2), y = decimals(m.y, 2);
  return "<polygon points=\"" + x + "," + decimals(m.y - m.radius, 2) + " " +
         decimals(m.x + m.radius, 2) + "," + y + " " + x + "," + decimals(m.y + m.radius, 2) + " " +
         decimals(m.x - m.radius, 2) + "," + y + "\"" + fill;
}

std::string element(const Drawing::Text& t) {
  static constexpr const char* anchors[] = {"start", "middle", "end"};
  std::string out = "<text" + attribute("x", t.x) + attribute("y", t.y) + " text-anchor=\"" +
                    anchors[static_cast<int>(t.anchor)] + "\" fill=\"" + hex(t.ink) + "\"";
  if (t.upwards)
    out += " transform=\"rotate(-90 " + decimals(t.x, 2) + " " + decimals(t.y, 2) + ")\"";
  return out + ">" + escaped(t.text) + "</text>\n";
}

}  // namespace

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

std::string svg_of(const Drawing& drawing) {
  const std::string width = std::to_string(drawing.width), height = std::to_string(drawing.height);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + width + " " +
                    height + "\" width=\"" + width + "\" height=\"" + height +
                    "\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" "
                    "height=\"100%\" fill=\"#ffffff\"/>\n";
  for (const auto& item : drawing.items)
    out += std::visit([](const auto& shape) { return element(shape); }, item);
  return out + "</svg>\n";
}

}  // namespace psivox
