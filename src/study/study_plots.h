#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "study/plot.h"
#include "study/results.h"
#include "study/variant.h"

namespace psivox {

struct NamedPlot {
  std::string name;  ///< of its files
  Plot plot;
};

/// Points of one rule and sampling, joined in their order.
struct PlotCurve {
  Variant variant;
  std::vector<std::pair<double, double>> points;
};

/// Curves in the rules' colours and the samplings' marks, with their legend, without titles.
Plot plot_of_curves(const std::vector<PlotCurve>& curves);

/// The rule's colour in every plot.
Ink ink_of(Integrator rule);

/// Writes it as SVG and as PNG; returns the SVG.
std::string write_plot(const NamedPlot& named, const std::filesystem::path& folder);

/// Error by step, by look-ups and by time. Times are those of the GPU's timer, where it has one,
/// and of the processor.
std::vector<NamedPlot> plots_of(const StudyResults& results);

}  // namespace psivox
