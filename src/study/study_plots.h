#pragma once

#include <vector>

#include "study/plot_page.h"
#include "study/results.h"
#include "study/variant.h"

namespace psivox {

/// The points of one rule and sampling, joined in their order.
struct PlotCurve {
  Variant variant;
  std::vector<PlotPoint> points;
};

/// Curves in the rules' colours and with the samplings' marks, and a legend. Titles are left empty.
Plot plot_of_curves(const std::vector<PlotCurve>& curves);

/// The rule's colour in every plot.
Ink ink_of(Integrator rule);

/// Plots of error by step, by look-ups, by GPU time if the driver has a timer, and by CPU time.
std::vector<NamedPlot> plots_of(const StudyResults& results);

}  // namespace psivox
