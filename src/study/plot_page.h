#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "study/plot.h"

namespace psivox {

struct NamedPlot {
  std::string name;  ///< of its file
  Plot plot;
};

/// Writes the plot as NAME.svg to the folder. Returns HTML: the SVG, and the plot's data for the
/// interactive chart that replaces the SVG where scripts run.
std::string write_plot(const NamedPlot& named, const std::filesystem::path& folder);

/// Labels and texts that describe a point.
using Facts = std::vector<std::pair<std::string, std::string>>;

/// HTML that a page's charts show for a point, found by the point's name. Once per page.
std::string html_facts(const std::map<std::string, Facts>& facts);

}  // namespace psivox
