#pragma once

#include <string>
#include <utility>
#include <vector>

#include "study/drawing.h"

namespace psivox {

/// Points joined in their order.
struct Series {
  std::vector<std::pair<double, double>> points;
  Ink ink;
  Drawing::Shape shape = Drawing::Shape::disc;
  bool dashed = false;
};

/// A line of the legend: a mark, with a line where `joined`.
struct LegendEntry {
  std::string text;
  Ink ink;
  Drawing::Shape shape = Drawing::Shape::disc;
  bool joined = false, dashed = false;
};

/// A plot with two logarithmic axes. Points with a number that is not above 0 have no place in it
/// and are left out.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Series> series;
  std::vector<LegendEntry> legend;
  std::vector<std::pair<double, double>> front;  ///< marked, and joined by steps
};

Drawing draw(const Plot& plot);

}  // namespace psivox
