#pragma once

#include "draw/trial_method.h"

namespace psivox {

/// What the arithmetic of float32 adds to a picture's RMS error (docs/method.md).
inline constexpr double arithmetic_error = 4e-7;

/// A small picture of a view, marched in double precision, on which methods are tried.
class Pilot {
 public:
  /// `exact`: the view by the method that is taken for the truth.
  Pilot(const View& exact, const MediumAtlas& atlas);

  /// Its picture, marched exactly.
  const Image& truth() const { return truth_; }
  /// Field look-ups of a ray of the truth.
  double exact_samples() const { return exact_samples_; }
  /// Whether some ray is more opaque than that.
  bool has_opacity(double opacity) const;
  /// Greatest radiance that a ray shows.
  double brightest() const;

  /// Field look-ups of a ray, from a few rays alone.
  double rough_samples(const MethodView& marched) const;
  /// Sets the errors and the look-ups of a trial, which is marched like that.
  void run(Trial& trial, const MethodView& marched) const;

 private:
  const MediumAtlas& atlas_;
  double exact_samples_ = 0;
  Image truth_;
};

}  // namespace psivox
