#include "draw/trials.h"

#include <algorithm>

#include "draw/plan.h"

namespace psivox {
namespace {

/// Fraction of the tolerance that the pilot's RMS may reach.
constexpr double safety = 0.8;

/// Largest error of a ray of the pilot [tolerances].
constexpr double worst_ray = 4;

/// Largest radiance assumed behind any brick, relative to the brightest ray of the pilot.
constexpr double brightness_share = 2;

/// A lattice is not tried if a few rays suggest that it costs this many times the best method.
constexpr double far_cost = 2;

/// The truth's rays end at this fraction of the transmittance at which the picture's rays end.
constexpr double truth_termination = 1.0 / 64;

View truth_of(View view) {
  const double early_termination = truth_termination * view.scene.resolved_early_termination();
  view = with_method(std::move(view), exact_method(view));
  view.scene.early_termination = early_termination;
  return view;
}

}  // namespace

Trials::Trials(const View& view, const MediumAtlas& atlas, double tolerance,
               const Progress& progress)
    : view_(view), atlas_(atlas), tolerance_(tolerance), pilot_(truth_of(view), atlas, progress) {
  view_.scene.early_termination = view.scene.resolved_early_termination();
}

double Trials::target() const { return safety * tolerance_; }

Trial Trials::run(const Method& method, double brick) {
  Trial trial{.method = method, .worst_brick = brick};
  const MethodView by_method = marched(trial);
  pilot_.run(trial, by_method);
  return finish(trial, by_method);
}

Trial Trials::run_exact() {
  const Method method = exact_method(view_);
  if (pilot_.has_opacity(1 - *view_.scene.early_termination)) return run(method);
  return finish({.method = method, .rms = arithmetic_error, .samples = pilot_.exact_samples()},
                {view_, {}, atlas_.paired});
}

Trial Trials::finish(Trial trial, const MethodView& marched) {
  trial.cost = look_up_cost(trial.method, marched) * trial.samples;
  trial.accepted = trial.rms <= target() && trial.max <= worst_ray * tolerance_;
  done_.push_back(trial);
  return trial;
}

const StepBounds& Trials::bounds() {
  if (!bounds_) bounds_.emplace(view_, atlas_, brightness_share * pilot_.brightest());
  return *bounds_;
}

std::vector<float> Trials::brick_parts(const Trial& trial) {
  return bounds().parts(trial.method.step, trial.worst_brick * tolerance_);
}

double Trials::widest(double brick) { return bounds().widest(brick * tolerance_); }

MethodView Trials::marched(const Trial& trial) {
  MethodView result{with_method(view_, trial.method), {}, atlas_.paired};
  if (trial.method.sampling != Sampling::uniform || tolerance_ <= 0) return result;
  std::vector<float> parts = brick_parts(trial);
  if (std::any_of(parts.begin(), parts.end(), [](float part) { return part < 1; }))
    result.brick_steps = std::make_shared<const std::vector<float>>(std::move(parts));
  return result;
}

double Trials::cost_by(Integrator rule, const Trial& trial) {
  MethodView by_rule = marched(trial);
  Method method = trial.method;
  method.integrator = by_rule.view.scene.integrator.emplace(rule);
  return look_up_cost(method, by_rule) * trial.samples;
}

bool Trials::costs_far_more(const Trial& lattice, double cost) {
  const std::vector<float> parts = brick_parts(lattice);
  double look_ups = 0;  // per voxel of a ray, as if rays met all bricks equally often
  for (const float part : parts) look_ups += 1 / (double(part) * lattice.method.step);
  look_ups *= pilot_.exact_samples() / double(parts.size());
  return look_ups > far_cost * cost && pilot_.rough_samples(marched(lattice)) > far_cost * cost;
}

}  // namespace psivox
