#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace psivox {

/// An sRGB colour.
struct Ink {
  std::uint8_t r = 0, g = 0, b = 0;
};
/// "#1f77b4", as HTML and SVG write it.
std::string hex(Ink ink);

enum class Shape { disc, square, diamond, ring, triangle };

struct PlotPoint {
  double x = 0, y = 0;
  std::string name{};           ///< shown by an interactive plot; may be empty
  double lower = 0, upper = 0;  ///< quartiles of x, joined by a line; 0: none
};

/// Whether a logarithmic plot can show the point: both numbers must be finite and above 0.
bool has_place(const PlotPoint& point);

/// Points joined in their order.
struct Series {
  std::vector<PlotPoint> points;
  Ink ink;
  Shape shape = Shape::disc;
  bool dashed = false;
  std::vector<std::string> entries{};  ///< its texts in the legend
};

/// Radii of marks, and of the rings of the front around them [pixels].
constexpr double mark_radius = 3.5, front_radius = 7;

/// A line of the legend: a mark, and a line through it if `joined`.
struct LegendEntry {
  std::string text;
  Ink ink;
  Shape shape = Shape::disc;
  bool joined = false, dashed = false;
  double radius = mark_radius;
};

/// A plot with two logarithmic axes. It leaves out points that these cannot show.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  std::vector<LegendEntry> legend;
  std::vector<PlotPoint> front;  ///< the Pareto front: marked, and joined by steps
};

/// The front as a series of rings, and its entry in the legend.
Series front_series(const Plot& plot);
LegendEntry front_entry();

std::string svg_of(const Plot& plot);

}  // namespace psivox
