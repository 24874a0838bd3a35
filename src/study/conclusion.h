#pragma once

#include <string>
#include <vector>

#include "study/page.h"
#include "study/results.h"

namespace psivox {

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

}  // namespace psivox
