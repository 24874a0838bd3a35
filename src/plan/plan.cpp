#include "plan/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/statistics.h"
#include "march/march_double.h"
#include "plan/trials.h"
#include "psivox/error.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Rays that must show something so that their errors tell those of the picture: a lattice may step
/// over features of a few pixels, of which the pilot meets none. If fewer do, the march is exact:
/// it costs little, as nearly all rays are empty. In 69 such pictures of narrow opacities
/// (frogtissue) lattices had an RMS of up to 1.1 tolerances, and one pixel was off by 166.
constexpr int fewest_telling = 32;

/// How many lattices are tried that are wider than one that will do, the part of what a method may
/// miss at which their steps aim, and how much wider they must be.
constexpr int most_wider = 2;
constexpr double aimed_error = 0.8, worth = 1.15;

/// The part of the rays on which lattices are tried, and by how much the steps are narrowed of one
/// that fails on the others.
constexpr double tried_part = 0.25, narrower_step = 0.85;

/// Maxima and surfaces have no step: cells find them.
bool has_step(const Scene& scene) { return scene.attenuates(); }

MarchPlan plan_of(Trials& trials, const Trial& chosen, bool reached) {
  MarchPlan plan{.chosen = chosen, .trials = trials.done(), .reached = reached};
  MethodView marched = trials.marched(chosen);
  const Image& truth = trials.pilot().truth();
  plan.rays = truth.width * truth.height;
  plan.samples = trials.pilot().all_samples();
  plan.march = std::make_shared<PlannedMarch>(PlannedMarch{std::move(marched.view),
                                                           std::move(marched.brick_steps),
                                                           truth,
                                                           {},
                                                           trials.pilot().behind(),
                                                           trials.through(),
                                                           trials.unmet()});
  return plan;
}

void consider(const Trial& trial, Trial& best) {
  if (trial.accepted && (!best.accepted || trial.cost < best.cost)) best = trial;
}

/// Linear segments in cells, for functions of the gradient, where the exact method is expensive.
/// More segments take more time.
void try_segments(Trials& trials, Trial& best) {
  for (const int segments : {1, 2, 4, 8, 16}) {
    consider(trials.run({.integrator = Integrator::psi_weighted, .segments = segments}, 0, best),
             best);
    if (best.method.segments == segments) return;
  }
}

/// Linear segments in cells, for lit functions: the exact method cuts cells at the function's knots
/// and looks its luminance up thrice in each piece.
void try_lit_segments(Trials& trials, double exact_samples, Trial& best) {
  for (const int segments : {1, 2}) {
    const Method method{.integrator = Integrator::psi_weighted, .segments = segments};
    if (best.accepted && trials.cost_of(method) * exact_samples >= best.cost) return;
    consider(trials.run(method, 0, best), best);
    if (best.method == method) return;
  }
}

/// Simpler rules by the steps of a lattice, where they take less time than `best`.
void try_simpler_rules(Trials& trials, const Trial& found, Trial& best) {
  if (found.method.integrator == Integrator::midpoint) return;
  for (const Integrator rule : {Integrator::porter_duff, Integrator::midpoint}) {
    // porter-duff is of first order where the step changes
    if (rule == Integrator::porter_duff && trials.marched(found).brick_steps) continue;
    if (best.accepted && trials.cost_by(rule, found) >= best.cost) continue;
    Method method = found.method;
    method.integrator = rule;
    consider(trials.run(method, found.worst_brick, best), best);
    if (best.method.integrator == rule) return;
  }
}

/// The cheapest of some lattices whose bricks may miss `brick` tolerances, in steps of `widest` or
/// less: at first steps at which errors of second order will do, then wider ones below those that
/// failed.
std::optional<Trial> find_lattice(Trials& trials, double widest, double brick, const Trial& best) {
  std::optional<Trial> found;
  double step = widest, failed = HUGE_VAL;
  for (int wider = 0; step >= narrowest_step && wider <= most_wider; wider += found.has_value()) {
    const Trial trial = trials.run(lattice(trials.view(), step), brick, best, tried_part);
    if (trial.accepted && found && trial.cost >= found->cost) break;
    if (trial.accepted)
      found = trial;
    else if (trials.is_slower(trial, best))  // narrower steps take more time
      break;
    else
      failed = step;
    const double ratio = std::sqrt(aimed_error * trials.target() / (found ? *found : trial).rms);
    if (!found) {
      step *= std::clamp(ratio, 1.0 / 8, 1.0 / 2);
    } else {
      const double narrow = found->method.step;
      step = std::min({narrow * ratio, std::sqrt(narrow * failed), widest});
      if (step < worth * narrow) break;
    }
  }
  return found;
}

/// Tries lattices with steps as wide as bricks allow. In case bricks require small steps
/// everywhere, it then tries wider ones whose bricks keep narrower steps. Simpler rules by the
/// steps found may beat `best` even if the lattice does not.
void try_lattices(Trials& trials, Trial& best) {
  const double widest = std::min(widest_step, trials.widest(worst_brick));
  std::optional<Trial> found = find_lattice(trials, widest, worst_brick, best);
  if (!found) return;
  const double wider = std::min(widest, 8 * found->method.step);
  if (wider > worth * found->method.step)
    if (const auto other = find_lattice(trials, wider, narrow_brick, *found);
        other && other->cost < found->cost)
      found = other;
  Trial whole;
  for (Method method = found->method; !whole.accepted; method.step *= narrower_step) {
    whole = trials.run(method, found->worst_brick, best);
    if (method.step < narrowest_step || trials.is_slower(whole, best)) return;
  }
  consider(whole, best);
  try_simpler_rules(trials, whole, best);
}

/// One pixel in each of about `count` cells of equal size.
std::vector<glm::ivec2> stratified_pixels(const glm::ivec2& size, int count) {
  const double share = std::min(1.0, double(count) / (double(size.x) * double(size.y)));
  const glm::ivec2 cells = glm::max(glm::ivec2(1), glm::ivec2(glm::dvec2(size) * std::sqrt(share)));
  std::mt19937 random(1);
  // std::uniform_int_distribution differs between standard libraries
  const auto pick = [&](int cell, int all, int extent) {
    const int first = int(std::int64_t(cell) * extent / all);
    const int last = int(std::int64_t(cell + 1) * extent / all);
    return first + int(random() % std::uint32_t(std::max(last - first, 1)));
  };
  std::vector<glm::ivec2> pixels;
  for (int y = 0; y < cells.y; ++y)
    for (int x = 0; x < cells.x; ++x) {
      const int at = pick(x, cells.x, size.x);
      pixels.emplace_back(at, pick(y, cells.y, size.y));
    }
  return pixels;
}

/// The view with the transmittance at which its rays end. What is left out of a ray is at most as
/// bright as the medium or what is behind it.
View with_termination(View view, const Backdrop& behind) {
  const double by_light = 2 * view.scene.resolved_early_termination() / behind.greatest();
  const bool given = view.scene.early_termination.has_value();
  view.scene.early_termination = early_termination(view);
  if (!given) *view.scene.early_termination = std::min(*view.scene.early_termination, by_light);
  return view;
}

}  // namespace

View exact_view(const View& view) {
  View exact = with_method(view, exact_method(view));
  exact.scene.early_termination = 0;
  exact.scene.filter = Filter::exact;
  exact.scene.texel = TexelType::float32;
  return exact;
}

MarchPlan exact_plan(const View& view) {
  MarchPlan plan;
  plan.chosen.method = exact_method(view);
  plan.chosen.rms = arithmetic_error;
  View exact = with_method(with_termination(view, Backdrop(view)), plan.chosen.method);
  plan.march = std::make_shared<PlannedMarch>(PlannedMarch{std::move(exact), {}, {}});
  return plan;
}

MarchPlan plan_march(const View& view, const MediumAtlas& atlas, const Progress& progress) {
  if (!has_step(view.scene)) return exact_plan(view);
  const Backdrop behind(view);
  Trials trials(with_termination(view, behind), behind, atlas, *view.scene.tolerance, progress);
  Trial best = trials.run_exact();
  if (!view.medium.others.empty()) return plan_of(trials, best, best.accepted);
  if (trials.pilot().telling_rays() < fewest_telling) return plan_of(trials, best, best.accepted);
  const double exact_samples = best.samples;
  if (view.medium.gradient) try_segments(trials, best);
  try_lattices(trials, best);
  if (view.medium.transfer && atlas.paired && !has_plain_voxels(view.medium))
    try_lit_segments(trials, exact_samples, best);
  return plan_of(trials, best, best.accepted);
}

void confirm(MarchPlan& plan, const Image& drawn, const Image* picture) {
  const PlannedMarch& march = *plan.march;
  ErrorSum errors = seen_errors(drawn, march.truth, march.behind);
  double rms = errors.rms();
  if (picture && !march.unmet.empty()) {
    const Backdrop behind(march.view);
    ErrorSum bright;
    for (const SeenPixel& seen : march.unmet) {
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

CheckedError exact_error(const View& exact, const Image& drawn) {
  return check_pixels(pilot_view(exact), drawn, drawn.width * drawn.height);
}

ErrorSum seen_errors(const Image& picture, const Image& truth, const Backdrop& behind) {
  if (picture.width != truth.width || picture.height != truth.height)
    throw Error(ExitCode::failure, "pictures of different sizes have no error");
  ErrorSum errors;
  for (std::size_t i = 0; i < truth.pixels(); ++i) {
    const glm::dvec4 difference = seen_error(truth, behind, i, &picture.rgba()[4 * i]);
    for (int c = 0; c < 4; ++c) errors.add(difference[c], i);
  }
  return errors;
}

Layer error_layer(const Image& picture, const Image& better, const Backdrop& behind,
                  double common) {
  Layer layer{"error", {"error"}, {}};
  layer.values.reserve(picture.pixels());
  for (std::size_t i = 0; i < picture.pixels(); ++i) {
    const double rms = glm::length(seen_error(better, behind, i, &picture.rgba()[4 * i])) / 2;
    layer.values.push_back(float(std::hypot(rms, common)));
  }
  return layer;
}

std::vector<WorldRay> checked_rays(const View& view, const Image& picture, int pixels) {
  const glm::ivec2 size(picture.width, picture.height);
  std::vector<WorldRay> rays;
  for (const glm::ivec2& place : stratified_pixels(size, pixels))
    for (int i = 0; i < view.scene.pixel_samples; ++i) {
      const glm::dvec2 at = glm::dvec2(place) + pixel_sample(i, view.scene.pixel_samples);
      rays.push_back(camera_ray(view.camera, size, at.x, at.y));
    }
  return rays;
}

CheckedError check_pixels(const View& view, const Image& picture, int pixels,
                          const Progress& progress) {
  const std::vector<glm::ivec2> places = stratified_pixels({picture.width, picture.height}, pixels);
  const std::vector<glm::dvec4> truth = reference_pixels(view, places, 1e-12, progress);
  CheckedError error{int(places.size())};
  ErrorSum sum;
  const Backdrop behind(view);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = picture.index(places[i].x, places[i].y);
    glm::dvec4 drawn;
    for (int c = 0; c < 4; ++c) drawn[c] = double(picture.rgba()[4 * at + std::size_t(c)]);
    const glm::dvec4 difference = behind.seen(drawn - truth[i], at);
    for (int c = 0; c < 4; ++c) sum.add(difference[c], i);
  }
  error.rms = sum.rms();
  error.max = sum.max;
  error.max_x = places[sum.max_at].x;
  error.max_y = places[sum.max_at].y;
  return error;
}

}  // namespace psivox
