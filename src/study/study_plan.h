#pragma once

#include <string>
#include <utility>
#include <vector>

#include "psivox/study.h"
#include "study/variant.h"

namespace psivox {

struct SkippedVariant {
  Variant variant;
  std::string reason;
};

/// Variants and the reason, one line per rule and reason: "cell-exact: step 4, step 2".
std::vector<std::pair<std::string, std::string>> skipped_lines(
    const std::vector<SkippedVariant>& skipped);

struct StudyPlan {
  std::vector<Variant> variants;  ///< grouped by texel and filter
  std::vector<SkippedVariant> skipped;
};

/// The combinations of the sweep without duplicates. It skips combinations that the scene refuses,
/// and records the reason.
StudyPlan plan_study(const Sweep& sweep, const Scene& base);

}  // namespace psivox
