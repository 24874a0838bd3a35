#pragma once

#include "draw/trial_method.h"

namespace psivox {

/// Contribution of float32 arithmetic to a picture's RMS error (docs/method.md).
inline constexpr double arithmetic_error = 4e-7;

/// A small picture of a view, marched in double precision, for trying methods.
class Pilot {
 public:
  /// `exact`: the view by the method that counts as the truth. `progress`: see plan_march.
  Pilot(const View& exact, const MediumAtlas& atlas, const Progress& progress);

  /// The pilot's picture, marched exactly.
  const Image& truth() const { return truth_; }
  /// Field look-ups per ray of the truth.
  double exact_samples() const { return exact_samples_; }
  /// Whether any ray is more opaque than `opacity`.
  bool has_opacity(double opacity) const;
  /// Largest radiance of a ray.
  double brightest() const;

  /// Field look-ups per ray, estimated from a few rays.
  double rough_samples(const MethodView& marched) const;
  /// Sets the errors and the look-ups of a trial, which `marched` marches.
  void run(Trial& trial, const MethodView& marched) const;

 private:
  /// The view's picture in another size. Sets `samples` to the look-ups per ray.
  Image march(const MethodView& marched, const glm::ivec2& size, double& samples) const;

  const MediumAtlas& atlas_;
  Progress progress_;
  double exact_samples_ = 0;
  Image truth_;
};

}  // namespace psivox
