#pragma once

#include <optional>

#include "draw/pilot.h"
#include "draw/step_bounds.h"

namespace psivox {

/// What a brick may miss at most by its bound, where no ray of the pilot meets it [tolerances]; and
/// the same where bricks keep narrower steps than they must, for a wider one elsewhere.
inline constexpr double worst_brick = 64, narrow_brick = 16;

/// Methods tried on the pilot of one view, for one tolerance; 0: for none.
class Trials {
 public:
  Trials(const View& view, const MediumAtlas& atlas, double tolerance);

  const View& view() const { return view_; }
  const Pilot& pilot() const { return pilot_; }
  const std::vector<Trial>& done() const { return done_; }

  /// RMS that a trial must reach: below the tolerance, since the pilot's rays are a sample.
  double target() const;

  /// The method on the pilot's rays.
  Trial run(const Method& method, double brick = 0);
  /// The exact method. It is the pilot's truth itself, unless rays end early.
  Trial run_exact();

  /// How a trial's method marches the view.
  MethodView marched(const Trial& trial);
  /// What the trial would cost by another rule with the same steps [look-ups of psi-balanced].
  double cost_by(Integrator rule, const Trial& trial);
  /// Whether a lattice takes far more than `cost` for the steps that its bricks ask for: where the
  /// bricks' mean step is that small, a few rays tell.
  bool costs_far_more(const Trial& lattice, double cost);

 private:
  std::vector<float> brick_parts(const Trial& trial);
  Trial finish(Trial trial, const MethodView& marched);

  View view_;
  const MediumAtlas& atlas_;
  double tolerance_;
  Pilot pilot_;
  std::optional<StepBounds> bounds_;
  std::vector<Trial> done_;
};

}  // namespace psivox
