#pragma once

#include <string>
#include <vector>

#include "study/drawing.h"

namespace psivox {

struct PlotPoint {
  double x = 0, y = 0;
  std::string name{};  ///< shown by an interactive plot; may be empty
};

/// Whether a logarithmic plot can show it: both numbers are finite and above 0.
bool has_place(const PlotPoint& point);

/// Points joined in their order.
struct Series {
  std::vector<PlotPoint> points;
  Ink ink;
  Drawing::Shape shape = Drawing::Shape::disc;
  bool dashed = false;
  std::vector<std::string> entries{};  ///< the legend's entries that describe it, by their texts
};

/// A line of the legend: a mark, with a line where `joined`.
struct LegendEntry {
  std::string text;
  Ink ink;
  Drawing::Shape shape = Drawing::Shape::disc;
  bool joined = false, dashed = false;
};

/// A plot with two logarithmic axes. It leaves out points that have no place.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  std::vector<LegendEntry> legend;
  std::vector<PlotPoint> front;  ///< the Pareto front: marked, and joined by steps
};

/// The Pareto front as rings with an entry of its own, which is front_entry().
Series front_series(const Plot& plot);
LegendEntry front_entry();

Drawing draw(const Plot& plot);

}  // namespace psivox
