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

/// Variants and reason, one line for each rule and reason: "cell-exact: step 4, step 2".
std::vector<std::pair<std::string, std::string>> skipped_lines(
    const std::vector<SkippedVariant>& skipped);

struct StudyPlan {
  std::vector<Variant> variants;  ///< grouped by texel and filter
  std::vector<SkippedVariant> skipped;
};

/// The sweep's combinations without duplicates. Combinations that the scene refuses are skipped,
/// with the reason.
StudyPlan plan_study(const Sweep& sweep, const Scene& base);

}  // namespace psivox
