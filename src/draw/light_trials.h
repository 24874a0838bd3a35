#pragma once

#include <map>
#include <optional>
#include <utility>

#include "draw/light_pilot.h"

namespace psivox {

/// The estimated error of the light may reach this fraction of what the light may miss, since the
/// pilot is a sample.
inline constexpr double light_safety = 0.8;

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
  int count = 0;      ///< of a sky's directions
  LightError miss{};  ///< expected, of directions and depths
};

/// Methods for some beams, by what they miss and cost. One budget, in quadrature, is for the depths
/// and for the directions of a sky.
class LightTrials {
 public:
  /// `directions`: of beams that stand for a sky's, whose number is chosen too; else null.
  LightTrials(const View& view, const MediumDepths& depths, BeamsOn beams, double rms,
              SkyTrial* directions = nullptr)
      : octaves_(view.scene.scatter_octaves),
        rms_(rms),
        directions_(directions),
        pilot_(view, depths, std::move(beams)) {}

  const LightPilot& pilot() const { return pilot_; }

  /// The lattice and the directions that are expected to take the least time, or exact rays. The
  /// error of a lattice that was not tried is expected from another's.
  LightChoice best();
  /// The same, with lattices tried until it is one of them.
  LightChoice settled();
  /// Takes down what a lattice misses, as it was computed.
  void learn(double spacing, const LightError& miss) { tried_[spacing] = miss; }
  /// Whether a lattice that was tried will do.
  bool enough(double spacing) const { return tried_.at(spacing).rms <= most(spacing); }

 private:
  /// What a lattice may miss. Of one light, the errors of lattices wider than a voxel are larger in
  /// few pixels.
  double most(double spacing) const {
    const double wide = directions_ ? 1 : std::max(1.0, spacing * spacing);
    return light_safety * rms_ / wide;
  }
  /// What a lattice misses, and whether that is known.
  std::pair<LightError, bool> expected(double spacing) const;

  int octaves_;
  double rms_;
  SkyTrial* directions_;
  std::map<double, LightError> tried_;  ///< by spacing
  LightPilot pilot_;
};

}  // namespace psivox
