#pragma once

#include "psivox/study.h"
#include "study/text_table.h"

namespace psivox {

/// needs_of() for people: a row for each rule and sampling, a column for each RMS.
TextTable needs_table(const StudyResults& results);

}  // namespace psivox
