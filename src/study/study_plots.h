#pragma once

#include <string>
#include <vector>

#include "psivox/study.h"
#include "study/plot.h"

namespace psivox {

struct NamedPlot {
  std::string name;  ///< of its files
  Plot plot;
};

/// Error by step, by look-ups and by time. Times are those of the GPU's timer, where it has one,
/// and of the processor.
std::vector<NamedPlot> plots_of(const StudyResults& results);

}  // namespace psivox
