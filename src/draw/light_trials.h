#pragma once

#include "draw/light_pilots.h"

namespace psivox {

/// The estimated error of the light may reach this fraction of what the light may miss, since the
/// pilot is a sample. For lattices wider than a voxel, whose errors are larger in few pixels, it is
/// divided by the square of the spacing.
inline constexpr double light_safety = 0.8;

void set_method(std::vector<Beam>& beams, const LightMethod& method);

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
  /// The method that misses little enough, as tried.
  LightMethod settled();
  /// What the method of first() is expected to miss, or that of settled() does.
  const LightError& first_miss() const { return first_miss_; }

  /// The next method after one that missed too much.
  LightMethod after(const LightMethod& method, double miss);

 private:
  LightError miss(const LightMethod& method) const;

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

/// Number of a sky's directions. Over clouds and smoke the error falls as one over their number
/// (docs/notes/decisions.md), so that a trial with few tells how many it takes. Of fewer the error
/// may be far larger, where few directions miss the phase function's peak: these are tried.
class SkyTrial {
 public:
  SkyTrial(const View& view, const MediumDepths& depths, double rms);
  int count() const { return count_; }
  const LightError& miss() const { return miss_; }
  double coverage() const { return coverage_; }

 private:
  static constexpr int few_count = 32, many_count = 128, truth_count = 256;
  int count_ = few_count;
  LightError miss_;
  double coverage_ = 0;
};

}  // namespace psivox
