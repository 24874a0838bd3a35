#pragma once

#include <functional>
#include <optional>

#include "draw/light_pilot.h"

namespace psivox {

/// What a sky misses by the number of its directions. Over clouds and smoke the error falls as one
/// over it (docs/notes/decisions.md), so that a trial with few tells how many a tolerance takes. Of
/// fewer the error may be far larger, where few directions miss the phase function's peak.
class SkyTrial {
 public:
  SkyTrial(const View& view, const MediumDepths& depths);
  /// The number of directions that is expected to miss at most so much, and what it misses.
  int count(double most);
  LightError miss(int count) const;
  /// LightPilot::coverage().
  double coverage() const { return pilot_.coverage(); }
  /// A count that was found, made larger if it is tried in vain.
  int tried(int count, double most) const;

 private:
  static constexpr int few_count = 32, many_count = 128;
  const View& view_;
  const MediumDepths& depths_;
  LightPilot pilot_;  ///< of many_count
  LightError few_;
  std::optional<LightError> many_;  ///< what many_count misses, if it was asked for
  double rate_ = 1;                 ///< power of the number with which the error falls
};

/// How the light of some beams is found.
struct LightChoice {
  LightMethod method{};
  int count = 1;      ///< of a sky's directions
  LightError miss{};  ///< expected, of directions and depths
};

/// Measures what some beams miss by a method.
using MeasureLight = std::function<LightError(const LightMethod& method)>;

/// The lattice, or exact rays, by which the pilot's beams take the least time and miss an RMS of at
/// most `rms`. The widest lattice tells which is expected to. That is measured, and what it misses
/// may tell of another one, until the last that was measured is chosen. `sky`: of beams that stand
/// for a sky's, whose number is chosen too; else null. Directions and depths share one budget, in
/// quadrature.
LightChoice choose_light(const LightPilot& pilot, double rms, SkyTrial* sky,
                         const MeasureLight& measure);

}  // namespace psivox
