#include "plan/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "plan/budget.h"
#include "plan/step_bounds.h"

namespace psivox {
namespace {

/// Rays that must show something so that their errors tell those of the picture: a lattice may step
/// over features of a few pixels, of which the pilot meets none. If fewer do, the march is exact:
/// it costs little, as nearly all rays are empty. In 69 such pictures of narrow opacities
/// (frogtissue) lattices had an RMS of up to 1.1 tolerances, and one pixel was off by 166.
constexpr int fewest_telling = 32;

/// The part of what a method may miss at which lattices aim, how much wider one must be to be tried
/// after another one, and how much narrower than one that failed, at most and at least.
constexpr double aimed_error = 0.9, worth = 1.12, narrowest_ratio = 1.0 / 8, widest_ratio = 0.7;

/// Nothing is worth so many times the exact method's look-ups, even if that misses the tolerance.
constexpr double hopeless = 64;

/// How far beyond a limit an estimate from so many rays must be to leave a method.
double doubt(std::size_t rays) { return 1 + 3 / std::sqrt(double(rays)); }

/// The view with the transmittance at which its rays end. What is left out of a ray is at most as
/// bright as the medium or what is behind it.
View with_termination(View view, const Backdrop& behind) {
  const double by_light = 2 * view.scene.resolved_early_termination() / behind.greatest();
  const bool given = view.scene.early_termination.has_value();
  view.scene.early_termination = early_termination(view);
  if (!given) *view.scene.early_termination = std::min(*view.scene.early_termination, by_light);
  return view;
}

struct Tried {
  Trial trial;
  MethodView marched;
};

/// Finds the cheapest method whose errors on the pilot's rays, and by the bounds of bricks, are
/// small enough.
class Search {
 public:
  Search(const View& view, const Backdrop& behind, const MediumAtlas& atlas,
         const Progress& progress)
      : view_(with_termination(view, behind)),
        atlas_(atlas),
        tolerance_(*view.scene.tolerance),
        limits_(budget::march(tolerance_)),
        pilot_(std::make_shared<Pilot>(view_, behind, atlas, progress)),
        through_(light_through(view_, atlas, behind, pilot_->unmet())),
        progress_(progress) {}

  MarchPlan plan() {
    try_exact();
    if (view_.medium.others.empty() && pilot_->telling_rays() >= fewest_telling) {
      try_segments();
      try_lattices();
    }
    MarchPlan plan{best_.trial, std::move(trials_), best_.trial.accepted};
    plan.rays = int(pilot_->truth().pixels());
    plan.samples = pilot_->all_samples();
    plan.march = std::make_shared<PlannedMarch>(
        PlannedMarch{std::move(best_.marched), pilot_, {}, through_});
    return plan;
  }

 private:
  MethodView view_of(const Method& method, BrickSteps brick_steps = {}) const {
    return {method, with_method(view_, method), std::move(brick_steps)};
  }

  /// Whether it takes longer than `factor` times the best method, or far longer if that misses the
  /// tolerance.
  bool slower(const Trial& trial, double factor = 1) const {
    const Trial& best = best_.trial;
    return best.cost > 0 && trial.cost > (best.accepted ? factor : hopeless) * best.cost;
  }

  /// Whether it may still be accepted.
  bool measure(Tried& tried, const RayErrors& errors) const {
    Trial& trial = tried.trial;
    trial.rays = int(errors.rays);
    trial.rms = errors.rms();
    trial.max = errors.max;
    trial.samples = errors.samples_per_ray();
    trial.cost = look_up_cost(tried.marched, atlas_.paired) * trial.samples;
    trial.accepted = errors.rays == errors.all_rays && limits_.keeps(trial.rms, trial.max);
    return limits_.keeps(errors.least_rms(), trial.max);
  }

  /// Runs the method on the pilot's rays until they show that it is beyond the limits, or that it
  /// takes longer than the best one. Its RMS and look-ups are then estimates.
  Trial run(const Method& method, BrickSteps brick_steps = {}) {
    Tried tried{{.method = method}, view_of(method, std::move(brick_steps))};
    const auto may_win = [&](const RayErrors& errors) {
      const double factor = doubt(errors.rays);
      return measure(tried, errors) && tried.trial.rms <= factor * limits_.rms &&
             !slower(tried.trial, factor);
    };
    pilot_->march(tried.marched, atlas_, progress_, may_win);
    consider(tried);
    return tried.trial;
  }

  void consider(const Tried& tried) {
    const Trial &trial = tried.trial, &best = best_.trial;
    trials_.push_back(trial);
    if (trials_.size() == 1 || (trial.accepted && (!best.accepted || trial.cost < best.cost)))
      best_ = tried;
  }

  void try_exact() {
    const Method method = exact_method(view_);
    if (view_.medium.gradient) {  // it misses something
      run(method);
      return;
    }
    Tried tried{{.method = method}, view_of(method)};
    measure(tried, pilot_->exact_errors());
    consider(tried);
  }

  void try_segments();
  double find_lattice(double widest, double brick);
  void try_lattices();

  View view_;
  const MediumAtlas& atlas_;
  double tolerance_;
  budget::Limits limits_;
  std::shared_ptr<Pilot> pilot_;
  std::vector<double> through_;
  Progress progress_;
  Tried best_;
  std::vector<Trial> trials_;
};

/// Linear segments in cells, where the exact method is expensive: for functions of the gradient,
/// and for lit functions, at whose knots it cuts cells and looks its luminance up thrice in each
/// piece.
void Search::try_segments() {
  const Medium& medium = view_.medium;
  if (!medium.gradient && !(medium.transfer && atlas_.paired && !has_plain_voxels(medium))) return;
  const double exact_samples = best_.trial.samples;
  for (const int segments : {1, 2, 4, 8, 16}) {
    const Method method{.integrator = Integrator::psi_weighted, .segments = segments};
    const double cost = look_up_cost(view_of(method), atlas_.paired) * exact_samples;
    if (best_.trial.accepted && cost >= best_.trial.cost) return;
    run(method);
    if (best_.trial.method == method) return;  // more segments take more time
  }
}

/// Tries lattices whose bricks may miss `brick` tolerances: the widest, then those that the last
/// one's error asks for, since errors are of second order, until one will do. Then wider ones are
/// tried, below the last that failed. Returns the step that will do; 0: none.
double Search::find_lattice(double widest, double brick) {
  const std::vector<double> bounded =
      bounded_steps(view_, atlas_, through_, pilot_->brightest(), brick * tolerance_);
  double step = widest, failed = HUGE_VAL, good = 0;
  while (step >= std::max(narrowest_step, worth * good)) {
    const Trial trial = run(lattice(view_.medium, step), fractions_of(step, bounded));
    const double ratio = std::sqrt(aimed_error / limits_.excess(trial.rms, trial.max));
    if (trial.accepted) {
      good = step;
      step = std::min(step * ratio, widest);
    } else {
      if (good == 0 && slower(trial)) break;  // narrower steps take more time
      failed = step;
      if (good == 0) step *= std::clamp(ratio, narrowest_ratio, widest_ratio);
    }
    if (good > 0) step = std::min(step, std::sqrt(good * failed));
  }
  return good;
}

/// In case bricks require small steps everywhere, wider ones are tried whose bricks keep narrower
/// ones.
void Search::try_lattices() {
  const double widest = widest_by_emission(view_.medium, atlas_, budget::worst_brick * tolerance_);
  const double found = find_lattice(widest, budget::worst_brick);
  const double wider = std::min(widest, 8 * found);
  if (wider > worth * found) find_lattice(wider, budget::narrow_brick);
}

}  // namespace

MarchPlan exact_plan(const View& view) {
  MarchPlan plan;
  plan.chosen.method = exact_method(view);
  plan.chosen.rms = arithmetic_error;
  View exact = with_method(with_termination(view, Backdrop(view)), plan.chosen.method);
  plan.march = std::make_shared<PlannedMarch>(PlannedMarch{{plan.chosen.method, std::move(exact)}});
  return plan;
}

MarchPlan plan_march(const View& view, const MediumAtlas& atlas, const Progress& progress) {
  // maxima and surfaces have no step: cells find them
  if (!view.scene.attenuates()) return exact_plan(view);
  Progress often;
  if (progress) often = [&progress](double) { progress(0); };
  return Search(view, Backdrop(view), atlas, often).plan();
}

void confirm(MarchPlan& plan, const Image& drawn, const Image* picture) {
  const Pilot& pilot = *plan.march->pilot;
  ErrorSum errors = seen_errors(drawn, pilot.truth(), pilot.behind());
  double rms = errors.rms();
  if (picture && !pilot.unmet().empty()) {
    const Backdrop behind(plan.march->view);
    ErrorSum bright;
    for (const SeenPixel& seen : pilot.unmet()) {
      const std::size_t at = picture->index(seen.pixel.x, seen.pixel.y);
      glm::dvec4 difference;
      for (int c = 0; c < 4; ++c)
        difference[c] = double(picture->rgba()[4 * at + std::size_t(c)]) - double(seen.picture[c]);
      difference = behind.seen(difference, at);
      for (int c = 0; c < 4; ++c) bright.add(difference[c], at);
    }
    rms = std::hypot(rms, std::sqrt(bright.squares / (4 * double(picture->pixels()))));
    errors += bright;
  }
  const double broken = std::numeric_limits<double>::infinity();
  const bool finite = std::isfinite(errors.squares);
  plan.chosen.rms = finite ? std::hypot(rms, plan.light_rms) : broken;
  plan.chosen.max = finite ? errors.max + plan.light_max : broken;
}

}  // namespace psivox
