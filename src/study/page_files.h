#pragma once

#include <map>
#include <string>

namespace psivox {

/// Texts that a page contains, by file name: page.css and plots.js from src/study/page, and
/// Chart.js as chart.min.js.
const std::map<std::string, std::string>& page_files();

}  // namespace psivox
