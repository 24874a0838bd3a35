#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "psivox/method.h"
#include "psivox/study.h"

namespace psivox {

/// A method, and the other parameters that a study varies. A tolerance chooses the method; then
/// only the resolution is read.
struct Variant {
  Method method;
  Filter filter = Filter::exact;
  TexelType texel = TexelType::float32;
  glm::ivec2 resolution{0};           ///< [pixels]; 0: the scene's
  std::optional<double> tolerance{};  ///< 0 in a refinement()
  bool operator==(const Variant&) const = default;
};

/// The row and the column of a variant in a table. The row is "psi-exact"; the column is "cells 2",
/// "step 0.5" or "template", then every filter, texel and resolution that is not the default. Under
/// a tolerance they are "chosen" and "for 0.001". A refinement() has "cells", "uniform" and "by
/// tolerance" as its columns.
std::string rule_name(const Variant& variant);
std::string sampling_name(const Variant& variant);
/// Both names together; and both as a file name without extension.
std::string variant_name(const Variant& variant);
std::string file_name(const Variant& variant);

Variant variant_of(Method method, const glm::ivec2& resolution);

bool differ_in_rule(Variant a, const Variant& b);

/// The scene that renders the variant.
Scene scene_of(const Variant& variant, const Scene& base);

/// Whether the picture depends on the rule and the segments: a maximum or a surface does not.
bool has_rules(const Scene& scene);
/// A sentence that says why the picture does not depend on them.
std::string no_rules_note(const Scene& scene);

/// The curve that a variant is a point of: the variant with step, segments and tolerance set to 0.
Variant refinement(Variant variant);
/// Whether `a` comes before `b` on their curve, which runs from coarse to fine.
bool is_coarser(const Variant& a, const Variant& b);

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
