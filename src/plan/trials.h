#pragma once

#include <functional>
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

/// What a method may miss on the pilot's rays.
struct ErrorLimits {
  double rms = 0;  ///< over all rays and R G B A
  double max = 0;  ///< of one channel of a ray
};

/// A method tried on rays of the pilot, some at a time. It is refused as soon as the rays marched
/// show that all together are beyond the limits.
class Attempt {
 public:
  /// The pilot must outlive it.
  Attempt(const Method& method, double brick, const MethodView& marched, const ErrorLimits& limits,
          Pilot& pilot);
  /// The exact method, whose errors the pilot knows.
  static Attempt exact(const Method& method, const MethodView& marched, const ErrorLimits& limits,
                       Pilot& pilot);

  /// What the rays so far show. The RMS and the look-ups are estimates from those in even order.
  const Trial& trial() const { return trial_; }
  const MethodView& marched() const { return marched_; }
  bool refused() const { return refused_; }
  bool complete() const { return even_ == pilot_->even_order().size(); }
  /// Errors by ray, of those marched.
  const std::vector<std::optional<RayError>>& errors() const { return errors_; }

  /// Marches the first `count` rays in even order, unless it is refused before.
  void march_evenly(std::size_t count);
  /// Marches these rays, but for those that were marched before.
  void march(std::span<const int> rays);

 private:
  void update();

  Trial trial_;
  double look_up_cost_;
  ErrorLimits limits_;
  Pilot* pilot_;
  MethodView marched_;
  std::optional<PixelMarch> march_;  ///< once it is needed
  std::vector<std::optional<RayError>> errors_;
  std::size_t even_ = 0;  ///< rays marched of the even order's beginning
  bool refused_ = false;
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
  double target() const;

  /// Runs the method on the pilot's rays, until it is refused.
  Trial run(const Method& method, double brick = 0);
  /// The exact method, which the pilot has marched already.
  Trial run_exact();
  /// Tries the method on a part of the rays, fewer if it is refused or may no longer win. In both
  /// cases it is not accepted.
  Trial try_out(const Method& method, double brick,
                const std::function<bool(const Trial&)>& may_win);
  /// Runs what was tried out on the other rays.
  Trial finish(const Trial& tried);

  /// Widest step that the emission allows where its bricks may miss `brick` tolerances.
  double widest(double brick);
  /// The view as the method of a trial that was made marches it.
  const MethodView& marched(const Trial& trial);
  /// Cost of a look-up of a method in cells [look-ups of psi-balanced].
  double cost_of(const Method& method);
  /// Cost of the trial's steps by another rule [look-ups of psi-balanced].
  double cost_by(Integrator rule, const Trial& trial);

 private:
  std::vector<SeenPixel> unmet_light(const Progress& progress) const;
  StepBounds& bounds();
  ErrorLimits limits() const;
  MethodView view_of(const Method& method, double brick);
  Attempt& attempt(const Method& method, double brick);
  Attempt& attempt_of(const Trial& trial);
  /// Runs it on the rays on which other methods were worst, which show soonest that it fails.
  void march_suspects(Attempt& attempt);
  /// Runs it on that part of the rays, unless it is refused before.
  void march_to(Attempt& attempt, double part);
  void keep_errors(const Attempt& attempt);

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

/// Finds the cheapest lattice that is accurate enough. It searches with the rule of lattice(), on a
/// part of the pilot's rays.
class LatticeSearch {
 public:
  /// `best`: the cheapest method so far, which a lattice must beat if that method is accepted.
  LatticeSearch(Trials& trials, const Trial& best) : trials_(trials), best_(best) {}

  /// Searches lattices with steps as wide as bricks allow. In case bricks require small steps
  /// everywhere, it then searches wider lattices whose bricks keep narrower steps.
  void search();

  /// The cheapest lattice that was accepted so far, perhaps on a part of the pilot's rays. Unset if
  /// none is, or if it cannot win.
  std::optional<Trial> found() const;
  /// Runs found() on all rays. If it is refused there, searches on and returns nothing.
  std::optional<Trial> settle();

 private:
  /// Halves the step, starting at `first`, until the error is small enough, then widens it as far
  /// as the error allows, below `coarse`. Stops when no lattice wider than `last` can be cheaper.
  void search_steps(double first, double last, double brick, std::optional<Trial> coarse = {});
  void widen(Trial coarse, Trial fine);
  Trial run(double step, double brick);
  /// Whether a lattice takes less than `factor` times the time of `best`, perhaps by a simpler
  /// rule.
  bool beats_best(const Trial& trial, double factor) const;
  /// Whether it, or a narrower one, may still be the cheapest, if times may be off by that factor.
  bool may_win(const Trial& trial, double factor) const;

  Trials& trials_;
  const Trial& best_;
  std::vector<Trial> accepted_;
};

}  // namespace psivox
