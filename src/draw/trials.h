#pragma once

#include <optional>

#include "draw/pilot.h"
#include "draw/step_bounds.h"

namespace psivox {

/// How much a brick that no ray of the pilot meets may miss, by its bound [tolerances]. The second
/// value is for bricks that keep narrower steps than they must, so that the step elsewhere can be
/// wider.
inline constexpr double worst_brick = 64, narrow_brick = 16;

/// Methods tried on the pilot of one view, for one tolerance; 0 if there is none.
class Trials {
 public:
  /// `progress`: see plan_march.
  Trials(const View& view, const MediumAtlas& atlas, double tolerance, const Progress& progress);

  const View& view() const { return view_; }
  const Pilot& pilot() const { return pilot_; }
  const std::vector<Trial>& done() const { return done_; }

  /// RMS that a trial must reach. It is below the tolerance because the pilot's rays are a sample.
  double target() const;

  /// Runs the method on the pilot's rays.
  Trial run(const Method& method, double brick = 0);
  /// Runs the exact method. Its picture is the pilot's truth, unless rays end early.
  Trial run_exact();

  /// Widest step that the emission allows where its bricks may miss `brick` tolerances.
  double widest(double brick);
  /// The view as a trial's method marches it.
  MethodView marched(const Trial& trial);
  /// Cost of the trial's steps by another rule [look-ups of psi-balanced].
  double cost_by(Integrator rule, const Trial& trial);
  /// Whether a lattice costs far more than `cost` because its bricks ask for small steps. If the
  /// bricks' mean step suggests it, a few rays decide.
  bool costs_far_more(const Trial& lattice, double cost);

 private:
  const StepBounds& bounds();
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
