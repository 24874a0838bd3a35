#pragma once

#include <string>

#include "study/results.h"
#include "study/text_table.h"

namespace psivox {

/// A header and one line for each point; numbers have all their digits.
std::string results_csv(const StudyResults& results);

/// Markdown: a table of rules by samplings, whose cells are "RMS (processor time over that of
/// porter-duff in the same column)", the table of needs, and the list of skipped variants.
std::string results_markdown(const StudyResults& results);

/// needs_of() for people: a row for each rule and sampling, a column for each RMS.
TextTable needs_table(const StudyResults& results);

}  // namespace psivox
