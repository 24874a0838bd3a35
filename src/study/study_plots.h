#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "study/page.h"
#include "study/results.h"
#include "study/variant.h"

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

struct Cost {
  double time = 0, error = 0;
};

/// Indices of the Pareto front, by time. A point joins the front if its error is less than (1 -
/// margin) times the least error of the cheaper points.
std::vector<std::size_t> pareto_front(const std::vector<Cost>& costs, double margin = 0);

struct NamedPlot {
  std::string name;  ///< of its file
  Plot plot;
};

/// Writes the plot as NAME.svg to the folder. Returns HTML: the SVG, and the plot's data for the
/// interactive chart that replaces the SVG where scripts run.
std::string write_plot(const NamedPlot& named, const std::filesystem::path& folder);

/// HTML that a page's charts show for a point, found by the point's name. Once per page.
std::string html_facts(const std::map<std::string, Facts>& facts);

/// The points of one rule and sampling, joined in their order.
struct PlotCurve {
  Variant variant;
  std::vector<PlotPoint> points;
};

/// Curves in the rules' colours and with the samplings' marks, and a legend. Titles are left empty.
Plot plot_of_curves(const std::vector<PlotCurve>& curves);

/// The rule's colour in every plot.
Ink ink_of(Integrator rule);

/// If a software renderer's wall times scatter between repeats and its processor times do not: a
/// sentence that says so; then the page plots processor time alone. Else empty.
std::string clock_note(const StudyResults& results);

/// Plots of error by step, by look-ups, by GPU time if the driver has a timer, and by CPU time.
std::vector<NamedPlot> plots_of(const StudyResults& results);

struct NamedStudy {
  std::string name;  ///< of its folder
  StudyResults results;
};

/// RMS by look-ups per ray: geometric means over the studies, at every RMS that all of them reach.
NamedPlot look_ups_plot(const std::vector<NamedStudy>& studies);

}  // namespace psivox
