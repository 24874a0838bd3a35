#pragma once

#include "psivox/error_control.h"

namespace psivox {

/// A small picture of a view, marched in double precision, on which ways to march it are tried.
class Pilot {
 public:
  /// `exact`: the view, set to the way that is taken for the truth.
  Pilot(const View& exact, const MediumAtlas& atlas);

  /// Its picture, marched exactly.
  const Image& truth() const { return truth_; }
  /// Field look-ups of a ray of the truth.
  double exact_samples() const { return exact_samples_; }
  /// Whether some ray is more opaque than that.
  bool has_opacity(double opacity) const;

  /// Greatest radiance that a ray shows.
  double brightest() const;

  /// Field look-ups of a ray by a few rays alone; `view` is set to the way that they are marched.
  double rough_samples(const View& view) const;

  /// Sets the errors and look-ups of a way; `view` is set to it.
  void run(Trial& way, const View& view) const;

 private:
  const MediumAtlas& atlas_;
  double exact_samples_ = 0;
  Image truth_;
};

/// What the arithmetic of float32 adds to a picture's RMS error (docs/method.md).
inline constexpr double arithmetic_error = 4e-7;

}  // namespace psivox
