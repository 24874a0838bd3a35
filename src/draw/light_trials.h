#pragma once

#include "draw/light_pilots.h"

namespace psivox {

/// The estimated error of the light may reach this fraction of what the light may miss, since the
/// pilot is a sample. For lattices wider than a voxel, whose errors are larger in few pixels, it is
/// divided by the square of the spacing.
inline constexpr double light_safety = 0.8;

void set_method(std::vector<Beam>& beams, const LightMethod& method);

/// What a sky misses by the number of its directions. Over clouds and smoke the error falls as one
/// over it (docs/notes/decisions.md), so that a trial with few tells how many a tolerance takes. Of
/// fewer the error may be far larger, where few directions miss the phase function's peak.
class SkyTrial {
 public:
  SkyTrial(const View& view, const MediumDepths& depths);
  /// The number of directions that is expected to miss at most so much, and what it misses.
  int count(double most);
  LightError miss(int count);
  /// LightPilots::coverage().
  double coverage() const { return pilots_.coverage(); }
  /// A count that was found, made larger if it is tried in vain.
  int tried(int count, double most) const;

 private:
  static constexpr int few_count = 32, many_count = 128;
  const View& view_;
  const MediumDepths& depths_;
  LightPilots pilots_;  ///< of many_count
  LightError few_;
  std::optional<LightError> many_;  ///< what many_count misses, if it was asked for
  double rate_ = 1;                 ///< power of the number with which the error falls
};

/// A sky's directions, and how the depths along them are found.
struct SkyMethod {
  int count = 0;
  LightMethod method{};
  LightError miss{};
};

/// Methods for some beams, by what they miss and cost.
class LightTrials {
 public:
  /// `blocks`: of the first volume.
  LightTrials(const View& view, const MediumDepths& depths, const std::vector<glm::ivec3>& blocks,
              BeamsOn beams, double rms)
      : octaves_(view.scene.scatter_octaves),
        depths_(depths),
        blocks_(blocks),
        beams_(std::move(beams)),
        rms_(rms),
        pilots_(view, depths, beams_) {}

  /// What `lit` misses, as estimated.
  LightError miss(const Medium& lit) const { return pilots_.error(lit); }
  /// Whether a lattice of a spacing that misses so much, as estimated, will do.
  bool enough(double miss, double spacing) const;

  /// The method to begin with: the coarsest lattice that is expected to be enough, but not below a
  /// voxel from so coarse a trial, or exact rays where they cost less.
  LightMethod first();
  /// What it is expected to miss.
  const LightError& first_miss() const { return first_miss_; }

  /// The next method after one that missed too much.
  LightMethod after(const LightMethod& method, double miss);

  /// Of a sky: the number of directions and the lattice that take the least time together, as
  /// tried.
  SkyMethod of_sky(SkyTrial& directions);

 private:
  LightError miss(const LightMethod& method) const;
  LightMethod rays() const;
  /// Time of a ray from each voxel, in look-ups of a lattice.
  double ray_look_ups();

  /// The coarsest lattice, from `spacing` down, that is expected to be enough; exact rays if none
  /// is or if they cost less. The lattice of `spacing` is expected to miss `miss`.
  LightMethod from(double spacing, double miss);

  int octaves_;
  const MediumDepths& depths_;
  const std::vector<glm::ivec3>& blocks_;
  BeamsOn beams_;
  double rms_;
  LightError first_miss_;
  std::optional<double> exact_look_ups_;
  LightPilots pilots_;
};

}  // namespace psivox
