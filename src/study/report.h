#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "study/page.h"
#include "study/results.h"

// What a study concludes, and its report.

namespace psivox {

/// The errors that tables ask for: RMS over R G B A, powers of ten.
inline const std::vector<double> usual_rms = {1e-2, 1e-3, 1e-4, 1e-5};
/// A power of ten as "1e-3".
std::string power_text(double rms);

/// Points of one refinement(), from coarse to fine.
using StudyCurve = std::vector<const StudyPoint*>;
/// The points' curves, in the order of their first points.
std::vector<StudyCurve> curves_of(const std::vector<const StudyPoint*>& points);

/// The cost at which a rule under a sampling reaches `rms`. It is interpolated linearly between
/// measured points, in logarithms of cost and error; unset if no point reaches it.
struct Need {
  Variant variant;  ///< the refinement: step, segments and tolerance are 0
  double rms = 0;
  std::optional<double> samples_per_ray, cpu_ms;
  bool at_most = false;  ///< the coarsest point already reaches it: the cost is an upper bound
};

/// One need for each refinement and RMS; refinements are in the order of their first points.
std::vector<Need> needs_of(const StudyResults& results,
                           const std::vector<double>& rms_wanted = usual_rms);

/// What a study recommends, by its own numbers. Of points whose pictures differ by rounding alone
/// it is the one by the default rule, or else the first.
struct Conclusion {
  /// The cheapest point that is within 8 bits. Null: there is none.
  const StudyPoint* eight_bits = nullptr;
  /// The cheapest point at the smallest RMS that any point reaches, in powers of ten, and the
  /// largest such RMS from which on it stays the cheapest. Null: no point reaches 1e-2.
  const StudyPoint* fine = nullptr;
  double fine_rms = 0;
};

/// The name of the first point whose picture differs from this one's by rounding alone.
std::string same_as(const StudyPoint& point);
/// All points whose pictures differ from `point`'s by rounding alone, itself among them. They
/// differ in their rule alone.
std::vector<const StudyPoint*> same_pictures(const StudyResults& results, const StudyPoint& point);

/// Whether 99 % of the values of radiance and of alpha differ by at most half a step of 8 bits, and
/// all are finite.
bool within_eight_bits(const StudyPoint& point);
inline constexpr const char* eight_bits_note =
    "Within 8 bits: 99 % of the values of radiance and of alpha differ from the reference by at "
    "most 1/510. Of all settings, the one with the fewest look-ups counts; where others have at "
    "most 5 % more, the one with the least processor time; where that differs by at most 20 %, the "
    "one with the least RMS.";

/// Points into `results`. Of several resolutions the largest counts. The cheapest point has the
/// fewest field look-ups; where others have hardly more, the least processor time decides, and
/// where that hardly differs, the least error.
Conclusion conclusion_of(const StudyResults& results);

/// The options that render a variant: "--step 2 --integrator psi-balanced", or "--step 2".
std::string options_of(const Variant& variant, bool with_rule = true);

/// The options that render variants which differ in their rule alone, and have the same picture:
/// "`--step 2 --integrator psi-balanced`", or "`--step 2` with average or psi-balanced".
std::string settings_text(const Scene& scene, const std::vector<Variant>& same);
/// A sentence that says why a conclusion names no rule, with a space before it; empty if it does.
std::string no_winner_note(const Scene& scene, bool lists_rules);

/// The conclusion in a sentence or two, with options in backquotes; empty without points.
std::string conclusion_text(const StudyResults& results);
/// The same as results.json has it.
Json conclusion_json(const StudyResults& results);

/// The folders of pictures in a study's folder. Each has a `file_name(variant)`.png for each point.
inline constexpr const char* pictures_folder = "pictures";
inline constexpr const char* differences_folder = "differences";

/// The page on which the study's picture turns, if there is one.
inline constexpr const char* turning_name = "turning.html";

/// File name, without extension, of the reference for a variant. There is one reference per
/// resolution.
std::string reference_name(const Variant& variant);

/// Writes results.md, the plots and index.html of the points that `results` has. The pictures must
/// be in the folder.
void write_report(const StudyResults& results, const std::filesystem::path& folder);

/// A paper from which a rule is.
struct RuleSource {
  const char* paper;
  const char* doi;
};
RuleSource source_of(Integrator rule);

/// A table with a row per rule and a column per sampling.
TextTable rules_table(const StudyResults& results);
/// needs_of() as a readable table: a row for each rule and sampling, a column for each RMS.
TextTable needs_table(const StudyResults& results);
/// A row for each rule and reason: "cell-exact: step 4, step 2".
TextTable skipped_table(const std::vector<SkippedVariant>& skipped);

}  // namespace psivox
