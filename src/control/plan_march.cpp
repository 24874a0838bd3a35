#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "control/pilot.h"
#include "control/step_bounds.h"
#include "psivox/end_corrections.h"
#include "psivox/error_control.h"
#include "psivox/renderer.h"

namespace psivox {
namespace {

/// Part of the tolerance that the pilot's RMS may take: its rays are a sample of the picture's.
constexpr double safety = 0.8;

/// Most that a pixel of the pilot may be off, and by the bound of each brick one that no ray of the
/// pilot meets, in tolerances.
constexpr double worst_pixel = 4;
constexpr double worst_brick = 64;
/// The same where the steps of bricks are made narrower than they must be, for a wider one
/// elsewhere.
constexpr double narrow_brick = 16;

/// Of the greatest radiance that a ray of the pilot shows, what may be behind any brick.
constexpr double brightness_share = 2;

/// How much costlier than the best way a lattice must look by a few rays before it is not tried.
constexpr double far_cost = 2;

/// Widest and narrowest lattice that are tried [voxels].
constexpr double widest_step = 16, narrowest_step = 1.0 / 64;

/// The truth's rays end at this part of the transmittance at which the picture's do.
constexpr double truth_termination = 1.0 / 64;

bool depth_alone(const View& view) {
  return view.medium.source == LuminanceSource::constant && !view.medium.transfer &&
         !view.medium.emission;
}

/// Time of a look-up over that of psi-balanced between uniform samples, the rest of a turn
/// included: measured on llvmpipe by psivox_bench_tolerance (docs/performance.md).
double look_up_cost(const Trial& way, const View& marched) {
  if (way.sampling == Sampling::uniform) {
    // end corrections look slopes up too, whether they are needed or not
    const double rule = has_end_corrections(marched)                ? 1.3
                        : depth_alone(marched)                      ? 1
                        : way.integrator == Integrator::midpoint    ? 0.85
                        : way.integrator == Integrator::porter_duff ? 0.8
                                                                    : 1;
    return marched.brick_steps ? 1.4 * rule : rule;
  }
  // a function's knots cut cells in pieces
  const double cell = marched.medium.transfer   ? 2.5
                      : marched.medium.emission ? 2
                      : depth_alone(marched)    ? 1.15
                                                : 1.75;
  return cell * std::max(1.0, way.segments / 2.0);
}

Trial exact_way(const View& view) {
  Trial way;
  if (view.medium.gradient) {  // along a cell the attenuation is no cubic then
    way.integrator = Integrator::psi_exact;
    way.segments = 32;
  } else if (!view.scene.composites()) {
    way.integrator = Integrator::psi_weighted;
  }
  return way;
}

Trial lattice(double step, double brick) {
  Trial way;
  way.worst_brick = brick;
  way.sampling = Sampling::uniform;
  way.integrator = Integrator::psi_balanced;
  way.step = step;
  return way;
}

/// What time budgets are counted in.
Trial budget_way() { return lattice(4, worst_brick); }

View set_way(View view, const Trial& way) {
  Scene& scene = view.scene;
  scene.tolerance.reset();
  scene.sampling = way.sampling;
  scene.integrator = way.integrator;
  scene.segments = way.segments;
  scene.step.reset();
  if (way.sampling == Sampling::uniform) scene.step = way.step;
  view.brick_steps.reset();
  return view;
}

View truth_of(View view, double early_termination) {
  view = set_way(std::move(view), exact_way(view));
  view.scene.early_termination = early_termination;
  return view;
}

class Planner {
 public:
  Planner(const View& view, const MediumAtlas& atlas, double tolerance)
      : view_(view),
        atlas_(atlas),
        tolerance_(tolerance),
        pilot_(truth_of(view, truth_termination * view.scene.resolved_early_termination()), atlas) {
    view_.scene.early_termination = view.scene.resolved_early_termination();
  }

  MarchPlan plan() {
    Trial best = exact_trial();
    for (const int segments : {1, 2, 4, 8, 16}) {
      if (!view_.medium.gradient) break;
      Trial way;
      way.integrator = Integrator::psi_weighted;
      way.segments = segments;
      consider(run(way), best);
    }
    if (!view_.medium.emission) search_lattices(best);
    return choose(best, best.accepted);
  }

  MarchPlan within(double part) {
    const double budget = part * run(budget_way()).cost;
    std::optional<Trial> best;
    const auto consider_time = [&](const Trial& trial) {
      if (trial.cost <= budget ? !best || best->cost > budget || trial.rms < best->rms
                               : !best || trial.cost < best->cost)
        best = trial;
      return trial.cost <= budget;
    };
    const bool exact = consider_time(exact_trial());
    for (double step = widest_step; !exact && step >= narrowest_step; step /= 2)
      if (!consider_time(run(lattice(step, worst_brick)))) break;
    return choose(*best, best->cost <= budget);
  }

 private:
  MarchPlan choose(const Trial& way, bool reached) {
    plan_.reached = reached;
    plan_.chosen = way;
    plan_.view = way_view(way);
    plan_.truth = pilot_.truth();
    return std::move(plan_);
  }

  double target() const { return safety * tolerance_; }

  std::vector<float> brick_parts(const Trial& way) {
    if (!bounds_) bounds_.emplace(view_, atlas_, brightness_share * pilot_.brightest());
    return bounds_->parts(way.step, way.worst_brick * tolerance_);
  }

  /// Whether a lattice takes far more than `best` for the steps that its bricks ask for: a few rays
  /// tell, where the bricks' mean step is that small.
  bool far_beyond(const Trial& way, const Trial& best) {
    if (!best.accepted) return false;
    const std::vector<float> parts = brick_parts(way);
    double look_ups = 0;  // in a voxel of a ray, bricks taken as equally often met
    for (const float part : parts) look_ups += 1 / (double(part) * way.step);
    look_ups *= pilot_.exact_samples() / double(parts.size());
    return look_ups > far_cost * best.cost &&
           pilot_.rough_samples(way_view(way)) > far_cost * best.cost;
  }

  View way_view(const Trial& way) {
    View view = set_way(view_, way);
    if (way.sampling != Sampling::uniform || tolerance_ <= 0) return view;
    std::vector<float> parts = brick_parts(way);
    if (std::any_of(parts.begin(), parts.end(), [](float part) { return part < 1; }))
      view.brick_steps = std::make_shared<const std::vector<float>>(std::move(parts));
    return view;
  }

  const Trial& finish(Trial way, const View& marched) {
    way.cost = look_up_cost(way, marched) * way.samples;
    way.accepted = way.rms <= target() && way.max <= worst_pixel * tolerance_;
    plan_.trials.push_back(way);
    return plan_.trials.back();
  }

  Trial run(Trial way) {
    const View marched = way_view(way);
    pilot_.run(way, marched);
    return finish(way, marched);
  }

  /// The truth is the picture, unless rays end early.
  Trial exact_trial() {
    Trial way = exact_way(view_);
    if (pilot_.has_opacity(1 - *view_.scene.early_termination)) return run(way);
    way.rms = arithmetic_error;
    way.samples = pilot_.exact_samples();
    return finish(way, view_);
  }

  static void consider(const Trial& trial, Trial& best) {
    if (trial.accepted && (!best.accepted || trial.cost < best.cost)) best = trial;
  }

  /// Lattices: with bricks' steps as wide as they may be, then, where that takes small steps
  /// everywhere, with a wider one whose bricks keep narrower ones. They are found by psi-balanced;
  /// the cheapest is tried with simpler rules too, which may be ahead of `best` where it is not.
  void search_lattices(Trial& best) {
    std::optional<Trial> found;
    search_lattice(widest_step, 0, worst_brick, best, found);
    if (!found) return;
    search_lattice(std::min(widest_step, 8 * found->step), found->step, narrow_brick, best, found);
    consider(*found, best);
    for (const Integrator rule : {Integrator::porter_duff, Integrator::midpoint}) {
      // of first order where the step changes
      if (rule == Integrator::porter_duff && way_view(*found).brick_steps) continue;
      if (cost_by(rule, *found, way_view(*found)) >= best.cost) continue;
      Trial way = *found;
      way.integrator = rule;
      consider(run(way), best);
      if (best.integrator == rule) return;
    }
  }

  /// What a lattice costs by another rule; `marched`: its view.
  static double cost_by(Integrator rule, Trial way, View marched) {
    way.integrator = rule;
    marched.scene.integrator = rule;
    return look_up_cost(way, marched) * way.samples;
  }

  /// Least that a lattice may cost by any rule.
  double least_cost(const Trial& way) {
    const View marched = way_view(way);
    return std::min({way.cost, cost_by(Integrator::porter_duff, way, marched),
                     cost_by(Integrator::midpoint, way, marched)});
  }

  /// The widest lattice from `first` on that is accurate enough, where one may be cheaper than
  /// `best` and is wider than `last`: halves the step until the error is small, then goes back as
  /// far as that allows. The cheapest becomes `found`.
  void search_lattice(double first, double last, double brick, const Trial& best,
                      std::optional<Trial>& found) {
    const auto see = [&](const Trial& trial) {
      if (trial.accepted && (!found || trial.cost < found->cost)) found = trial;
    };
    std::optional<Trial> coarse;
    for (double step = first; step >= std::max(1.1 * last, narrowest_step); step /= 2) {
      if (far_beyond(lattice(step, brick), best)) return;
      const Trial fine = run(lattice(step, brick));
      see(fine);
      if (fine.accepted) {
        if (coarse) refine(*coarse, fine, see);
        return;
      }
      const double bound = found ? found->cost : best.cost;  // exact, or good enough
      if ((found ? fine.cost : least_cost(fine)) > bound) return;
      coarse = fine;
    }
  }

  template <typename See>
  void refine(Trial coarse, Trial fine, const See& see) {
    for (int i = 0; i < 3 && coarse.step > 1.12 * fine.step; ++i) {
      const double slope = std::log(coarse.rms / fine.rms) / std::log(coarse.step / fine.step);
      double ratio = slope > 0.5 ? std::pow(target() / fine.rms, 1 / slope) : 1;
      if (coarse.rms <= target()) ratio = std::sqrt(coarse.step / fine.step);  // one ray is off
      ratio = std::clamp(ratio, 1.1, 0.95 * coarse.step / fine.step);
      const Trial between = run(lattice(fine.step * ratio, fine.worst_brick));
      see(between);
      (between.accepted ? fine : coarse) = between;
    }
  }

  View view_;
  const MediumAtlas& atlas_;
  double tolerance_;
  Pilot pilot_;
  std::optional<StepBounds> bounds_;
  MarchPlan plan_;
};

}  // namespace

View exact_view(const View& view) {
  View exact = truth_of(view, 0);
  exact.scene.filter = Filter::exact;
  return exact;
}

namespace {

/// Maxima and surfaces have no step: cells find them.
MarchPlan only_plan(const View& view) {
  MarchPlan plan;
  plan.chosen = exact_way(view);
  plan.chosen.rms = arithmetic_error;
  plan.view = set_way(view, plan.chosen);
  return plan;
}

bool has_step(const Scene& scene) { return scene.composites() || scene.mode == Mode::xray; }

}  // namespace

MarchPlan plan_march(const View& view, const MediumAtlas& atlas) {
  if (!has_step(view.scene)) return only_plan(view);
  return Planner(view, atlas, *view.scene.tolerance).plan();
}

MarchPlan plan_within(const View& view, const MediumAtlas& atlas, double budget) {
  if (!has_step(view.scene)) return only_plan(view);
  return Planner(view, atlas, 0).within(budget);
}

void confirm(MarchPlan& plan, const Image& drawn) {
  const Comparison c = compare_images(drawn, plan.truth);
  const double broken = std::numeric_limits<double>::infinity();
  plan.chosen.rms = c.not_finite ? broken : c.rms;
  plan.chosen.max = c.not_finite ? broken : c.max;
}

double device_error(const View& exact, const MediumAtlas& atlas, const Image& drawn) {
  return compare_images(drawn, render_march_double(pilot_view(exact), atlas).image).rms;
}

View budget_unit(const View& view) { return set_way(view, budget_way()); }

std::string trial_text(const Trial& trial) {
  std::string rule = info(trial.integrator).name;
  std::replace(rule.begin(), rule.end(), '_', '-');
  char text[96];
  if (trial.sampling == Sampling::uniform)
    std::snprintf(text, sizeof text, "uniform %s, step %.3g", rule.c_str(), trial.step);
  else if (is_cell_rule(trial.integrator))
    std::snprintf(text, sizeof text, "cells %s", rule.c_str());
  else
    std::snprintf(text, sizeof text, "cells %s, segments %d", rule.c_str(), trial.segments);
  return text;
}

}  // namespace psivox
