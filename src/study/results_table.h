#pragma once

#include <string>
#include <vector>

#include "psivox/study.h"

namespace psivox {

/// Rows of cells, the first the head.
using TextTable = std::vector<std::vector<std::string>>;

/// needs_of() for people: a row for each rule and sampling, a column for each RMS.
TextTable needs_table(const StudyResults& results);

}  // namespace psivox
