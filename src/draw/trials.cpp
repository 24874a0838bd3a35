#include "draw/trials.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "draw/plan.h"

namespace psivox {
namespace {

/// Fraction of the tolerance that the pilot's RMS may reach.
constexpr double safety = 0.8;

/// Largest error of a ray of the pilot [tolerances].
constexpr double worst_ray = 4;

/// Largest radiance assumed behind any brick, relative to the brightest ray of the pilot.
constexpr double brightness_share = 2;

/// The truth's rays end at this fraction of the transmittance at which the picture's rays end.
constexpr double truth_termination = 1.0 / 64;

/// Rays that tell whether a method may win, and the part of the rays on which it is tried out.
constexpr std::size_t first_rays = 48;
constexpr double tried_part = 0.25;

/// Rays on which another method's error was worst: how many, and their least error [tolerances].
constexpr std::size_t most_suspects = 24;
constexpr double suspect_error = 1;

/// The view by the exact method.
View exactly(const View& view, double termination) {
  View exact = with_method(view, exact_method(view));
  exact.scene.early_termination = termination * view.scene.resolved_early_termination();
  return exact;
}

}  // namespace

Trials::Trials(const View& view, const MediumAtlas& atlas, double tolerance,
               const Progress& progress)
    : view_(view),
      atlas_(atlas),
      tolerance_(tolerance),
      pilot_(exactly(view, truth_termination), exactly(view, 1), atlas, progress),
      last_errors_(pilot_.even_order().size()) {
  view_.scene.early_termination = view.scene.resolved_early_termination();
}

double Trials::target() const { return safety * tolerance_; }

std::vector<Trial> Trials::done() const {
  std::vector<Trial> trials;
  for (const Attempt& attempt : attempts_) trials.push_back(attempt.trial());
  return trials;
}

ErrorLimits Trials::limits() const {
  constexpr double any = std::numeric_limits<double>::infinity();
  if (tolerance_ <= 0) return {any, any};
  return {target(), worst_ray * tolerance_};
}

Attempt& Trials::attempt(const Method& method, double brick) {
  return attempts_.emplace_back(method, brick, view_of(method, brick), limits(), pilot_);
}

Attempt& Trials::attempt_of(const Trial& trial) {
  return *std::find_if(attempts_.begin(), attempts_.end(), [&](const Attempt& attempt) {
    return attempt.trial().method == trial.method &&
           attempt.trial().worst_brick == trial.worst_brick;
  });
}

void Trials::march_suspects(Attempt& attempt) {
  std::vector<int> rays(last_errors_.size());
  std::iota(rays.begin(), rays.end(), 0);
  const auto error = [&](int ray) { return last_errors_[std::size_t(ray)]; };
  std::erase_if(rays, [&](int ray) { return error(ray) <= suspect_error * tolerance_; });
  std::stable_sort(rays.begin(), rays.end(), [&](int a, int b) { return error(a) > error(b); });
  rays.resize(std::min(rays.size(), most_suspects));
  attempt.march(rays);
}

void Trials::keep_errors(const Attempt& attempt) {
  for (std::size_t ray = 0; ray < last_errors_.size(); ++ray)
    if (const auto& error = attempt.errors()[ray]) last_errors_[ray] = error->largest;
}

void Trials::march_to(Attempt& attempt, double part) {
  attempt.march_evenly(first_rays);
  if (!attempt.refused()) march_suspects(attempt);
  attempt.march_evenly(std::size_t(part * double(pilot_.even_order().size())));
  keep_errors(attempt);
}

Trial Trials::run(const Method& method, double brick) {
  Attempt& whole = attempt(method, brick);
  march_to(whole, 1);
  return whole.trial();
}

Trial Trials::try_out(const Method& method, double brick,
                      const std::function<bool(const Trial&)>& may_win) {
  Attempt& tried = attempt(method, brick);
  tried.march_evenly(first_rays);
  if (tried.refused() || may_win(tried.trial())) march_to(tried, tried_part);
  Trial trial = tried.trial();
  trial.accepted = trial.accepted && may_win(trial);
  return trial;
}

Trial Trials::finish(const Trial& tried) {
  Attempt& whole = attempt_of(tried);
  march_to(whole, 1);
  return whole.trial();
}

Trial Trials::run_exact() {
  const Method method = exact_method(view_);
  attempts_.push_back(Attempt::exact(method, view_of(method, 0), limits(), pilot_));
  return attempts_.back().trial();
}

double Trials::widest(double brick) { return bounds().widest(brick * tolerance_); }

StepBounds& Trials::bounds() {
  if (!bounds_) bounds_.emplace(view_, atlas_, brightness_share * pilot_.brightest());
  return *bounds_;
}

MethodView Trials::view_of(const Method& method, double brick) {
  MethodView result{with_method(view_, method), {}, atlas_.paired};
  if (method.sampling == Sampling::uniform && tolerance_ > 0)
    result.brick_steps = bounds().parts(method.step, brick * tolerance_);
  return result;
}

const MethodView& Trials::marched(const Trial& trial) { return attempt_of(trial).marched(); }

double Trials::cost_of(const Method& method) { return look_up_cost(method, view_of(method, 0)); }

double Trials::cost_by(Integrator rule, const Trial& trial) {
  MethodView by_rule = marched(trial);
  Method method = trial.method;
  method.integrator = by_rule.view.scene.integrator.emplace(rule);
  return look_up_cost(method, by_rule) * trial.samples;
}

}  // namespace psivox
