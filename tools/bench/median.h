#pragma once

#include <utility>
#include <vector>

#include "psivox/statistics.h"

namespace psivox::bench {

inline double median(std::vector<double> values) { return spread_of(std::move(values)).median; }

}  // namespace psivox::bench
