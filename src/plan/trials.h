#pragma once

#include <map>
#include <optional>
#include <vector>

#include "plan/light_through.h"
#include "plan/pilot.h"

namespace psivox {

/// Widest and narrowest step tried [voxels].
inline constexpr double widest_step = 16, narrowest_step = 1.0 / 64;

/// Bounds, from the values stored in each brick, how much a uniform step can miss there, so that no
/// feature between samples is lost. (docs/method.md, "Asked for an error")
class StepBounds {
 public:
  /// `brightest`: the largest radiance behind any brick that the pilot met; `through`: see
  /// light_through. The atlas must outlive it.
  StepBounds(const View& view, const MediumAtlas& atlas, double brightest,
             std::span<const double> through);

  /// For each brick, the fraction of the step at which its bound is `error` [radiance, opacity], at
  /// most 1. Null where all are 1.
  BrickSteps parts(double step, double error);

  /// The widest step at which the bound of the emission is `error` [radiance]; infinite without
  /// emission. It holds everywhere, since a flame goes beyond the density's bricks.
  double widest(double error) const;

 private:
  /// A step h misses an optical depth of at most the lesser of second * h^2 and first * h.
  struct Bound {
    double first = 0;
    double second = 0;
    double effect = 1;  ///< error of opacity or radiance if everything is missed
    double slope = 1;   ///< greatest of the attenuation by the values
    double turn = 0;    ///< sum of its changes

    /// The step at which it is `depth` [optical depth].
    double step(double depth) const;
  };
  /// Adds to the wanted bounds the kinks on faces and where a function bends.
  void complete(const std::vector<bool>& wanted);
  /// `place`: in the medium's emission.
  void bound_emission(const Medium& medium, std::size_t place, const BrickAtlas& emission);
  /// For each brick, the step at which its bound is `error`.
  const std::vector<double>& steps(double error);

  const BrickAtlas& density_;
  double kink_scale_;  ///< optical depth that a step of 1 may miss at a kink of 1
  std::vector<Bound> bounds_;
  /// Where `second` counts all kinks, and not only those inside the brick.
  std::vector<bool> complete_;
  std::map<double, std::vector<double>> steps_;  ///< by error
  std::vector<Bound> emission_;                  ///< of the emission's bricks [radiance]
};

/// Fraction of the tolerance that the pilot's RMS may reach.
inline constexpr double pilot_safety = 0.8;

/// Largest error of a ray of the pilot [tolerances].
inline constexpr double worst_ray = 4;

/// How much a brick that no ray of the pilot meets may miss, by its bound [tolerances]. The second
/// value is for bricks that keep narrower steps than they must, so that the step elsewhere can be
/// wider.
inline constexpr double worst_brick = 64, narrow_brick = 16;

/// Methods tried on the pilot of one view for one tolerance.
class Trials {
 public:
  /// The view has the transmittance at which rays end. `progress`: see plan_march.
  Trials(const View& view, const Backdrop& behind, const MediumAtlas& atlas, double tolerance,
         const Progress& progress);

  const View& view() const { return view_; }
  const Pilot& pilot() const { return pilot_; }
  /// Pixels that are brighter than what the pilot's rays let expect.
  const std::vector<SeenPixel>& unmet() const { return unmet_; }
  /// See light_through.
  const std::vector<double>& through() const { return through_; }
  std::vector<Trial> done() const;

  /// RMS that a trial must reach. It is below the tolerance because the pilot's rays are a sample.
  double target() const { return pilot_safety * tolerance_; }

  /// Runs the method on the pilot's rays, or on a part of them, some at a time, until they show
  /// that all together are beyond the limits, or that it takes longer than `best`. RMS and look-ups
  /// are then estimates.
  Trial run(const Method& method, double brick, const Trial& best, double part = 1);
  /// The exact method, which the pilot has marched already.
  Trial run_exact();

  /// Widest step that the emission allows where its bricks may miss `brick` tolerances.
  double widest(double brick) { return bounds().widest(brick * tolerance_); }
  /// The view as the method of a trial that was made marches it.
  const MethodView& marched(const Trial& trial) const;
  /// Cost of a look-up of a method in cells [look-ups of psi-balanced].
  double cost_of(const Method& method) { return look_up_cost(method, view_of(method, 0)); }
  /// Cost of the trial's steps by another rule [look-ups of psi-balanced].
  double cost_by(Integrator rule, const Trial& trial) const;
  /// Whether a trial takes longer than `factor` times the best method, or far longer if that is not
  /// accepted. Beside cells the rule that costs least counts.
  bool is_slower(const Trial& trial, const Trial& best, double factor = 1) const;

 private:
  struct Attempt {
    Trial trial;
    MethodView marched;
  };

  std::vector<SeenPixel> unmet_light(const Progress& progress) const;
  StepBounds& bounds();
  MethodView view_of(const Method& method, double brick);
  /// Measures a trial by the errors of the rays that were marched, among which are the first
  /// `even` in even order. Returns whether all rays may be within the limits.
  bool measure(Trial& trial, std::span<const std::optional<RayError>> errors,
               std::size_t even) const;
  /// The rays on which the last methods were worst, which show soonest that another fails.
  std::vector<int> suspects() const;

  View view_;
  const MediumAtlas& atlas_;
  double tolerance_;
  Pilot pilot_;
  std::vector<SeenPixel> unmet_;
  std::vector<double> through_;
  std::optional<StepBounds> bounds_;
  std::vector<Attempt> attempts_;
  std::vector<double> last_errors_;  ///< by ray, of the method that marched it last; else 0
};

}  // namespace psivox
