#include "plan/trials.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "plan/plan.h"

namespace psivox {
namespace {

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

/// The view by the truth's method: the exact one, or twice its segments where these miss something.
View exactly(const View& view, double termination) {
  Method method = exact_method(view);
  if (view.medium.gradient) method.segments *= 2;
  View exact = with_method(view, method);
  *exact.scene.early_termination *= termination;
  return exact;
}

/// A lattice is left if its first rays suggest that it costs this many times the best method.
constexpr double far_cost = 2;

/// A lattice between two is tried if it may save this part of the time: trying it takes about a
/// hundredth of the picture's.
constexpr double worth = 0.03;

}  // namespace

Attempt::Attempt(const Method& method, double brick, const MethodView& marched,
                 const ErrorLimits& limits, Pilot& pilot)
    : trial_{.method = method, .worst_brick = brick},
      look_up_cost_(look_up_cost(method, marched)),
      limits_(limits),
      pilot_(&pilot),
      marched_(marched),
      errors_(pilot.even_order().size()) {}

Attempt Attempt::exact(const Method& method, const MethodView& marched, const ErrorLimits& limits,
                       Pilot& pilot) {
  Attempt attempt(method, 0, marched, limits, pilot);
  const auto errors = pilot.exact_errors();
  attempt.errors_.assign(errors.begin(), errors.end());
  attempt.even_ = errors.size();
  attempt.update();
  return attempt;
}

void Attempt::march_evenly(std::size_t count) {
  const auto order = pilot_->even_order();
  count = std::min(count, order.size());
  while (even_ < count && !refused_) {
    const std::size_t next = std::min(count, 2 * std::max<std::size_t>(even_, 24));
    march(order.subspan(even_, next - even_));
    even_ = next;
    update();
  }
}

void Attempt::march(std::span<const int> rays) {
  std::vector<int> wanted;
  std::copy_if(rays.begin(), rays.end(), std::back_inserter(wanted),
               [&](int ray) { return !errors_[std::size_t(ray)]; });
  if (!march_) march_ = pilot_->march_of(marched_);
  std::vector<RayError> found(wanted.size());
  pilot_->march(*march_, wanted, found);
  for (std::size_t i = 0; i < wanted.size(); ++i) errors_[std::size_t(wanted[i])] = found[i];
  update();
}

void Attempt::update() {
  double all_squares = 0;
  trial_.rays = 0;
  for (const std::optional<RayError>& error : errors_) {
    if (!error) continue;
    ++trial_.rays;
    all_squares += error->squares;
    trial_.max = std::max(trial_.max, error->largest);
  }
  const auto rms = [](double squares, std::size_t rays) {
    return std::hypot(std::sqrt(squares / (4 * double(rays))), arithmetic_error);
  };
  refused_ = rms(all_squares, errors_.size()) > limits_.rms || trial_.max > limits_.max;
  if (even_ == 0) return;

  double squares = 0, samples = 0, exact_samples = 0, all_exact_samples = 0;
  for (const int ray : pilot_->even_order().first(even_)) {
    squares += errors_[std::size_t(ray)]->squares;
    samples += errors_[std::size_t(ray)]->samples;
    exact_samples += pilot_->exact_samples()[std::size_t(ray)];
  }
  for (const double of_ray : pilot_->exact_samples()) all_exact_samples += of_ray;
  trial_.rms = rms(squares, even_);
  // rays differ less in the ratio of their look-ups than in their number
  const double all = exact_samples > 0 ? samples * all_exact_samples / exact_samples
                                       : samples * double(errors_.size()) / double(even_);
  trial_.samples = complete() ? samples / double(even_) : all / double(errors_.size());
  trial_.cost = look_up_cost_ * trial_.samples;
  trial_.accepted = !refused_ && trial_.rms <= limits_.rms;
}

Trials::Trials(const View& view, const Backdrop& behind, const MediumAtlas& atlas, double tolerance,
               const Progress& progress)
    : view_(view),
      atlas_(atlas),
      tolerance_(tolerance),
      pilot_(exactly(view, truth_termination), exactly(view, 1), behind, atlas, progress),
      unmet_(unmet_light(progress)),
      through_(light_through(view, atlas, behind, unmet_)),
      last_errors_(pilot_.even_order().size()) {}

std::vector<SeenPixel> Trials::unmet_light(const Progress& progress) const {
  const std::vector<glm::ivec2> pixels = glowing_pixels(view_, atlas_);
  if (pixels.empty()) return {};
  std::vector<MarchedRay> rays(pixels.size());
  PixelMarch(exactly(view_, truth_termination), atlas_).march(pixels, rays, progress);
  std::vector<SeenPixel> seen;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const SeenPixel pixel{pixels[i], rays[i].picture};
    if (pixel.radiance() > brightness_share * pilot_.brightest()) seen.push_back(pixel);
  }
  return seen;
}

double Trials::target() const { return pilot_safety * tolerance_; }

std::vector<Trial> Trials::done() const {
  std::vector<Trial> trials;
  for (const Attempt& attempt : attempts_) trials.push_back(attempt.trial());
  return trials;
}

ErrorLimits Trials::limits() const { return {target(), worst_ray * tolerance_}; }

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
  if (view_.medium.gradient) return run(method, 0);  // it misses something
  attempts_.push_back(Attempt::exact(method, view_of(method, 0), limits(), pilot_));
  return attempts_.back().trial();
}

double Trials::widest(double brick) { return bounds().widest(brick * tolerance_); }

StepBounds& Trials::bounds() {
  if (!bounds_) bounds_.emplace(view_, atlas_, brightness_share * pilot_.brightest(), through_);
  return *bounds_;
}

MethodView Trials::view_of(const Method& method, double brick) {
  MethodView result{with_method(view_, method), {}, atlas_.paired};
  if (method.sampling == Sampling::uniform)
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

void LatticeSearch::search() {
  const double widest = std::min(widest_step, trials_.widest(worst_brick));
  search_steps(widest, 0, worst_brick);
  const std::optional<Trial> first = found();
  if (!first) return;
  const double step = first->method.step;
  search_steps(std::min(widest, 8 * step), step, narrow_brick);
}

std::optional<Trial> LatticeSearch::found() const {
  const auto cheapest =
      std::min_element(accepted_.begin(), accepted_.end(),
                       [](const Trial& a, const Trial& b) { return a.cost < b.cost; });
  if (cheapest == accepted_.end() || !beats_best(*cheapest, 1)) return {};
  return *cheapest;
}

std::optional<Trial> LatticeSearch::settle() {
  const Trial tried = *found();
  const Trial whole = trials_.finish(tried);
  if (whole.accepted) return whole;
  std::erase_if(accepted_, [&](const Trial& trial) {
    return trial.method == tried.method && trial.worst_brick == tried.worst_brick;
  });
  std::optional<Trial> finer;  // the next one
  for (const Trial& trial : accepted_)
    if (trial.worst_brick == whole.worst_brick && trial.method.step < whole.method.step &&
        (!finer || trial.method.step > finer->method.step))
      finer = trial;
  if (finer)
    widen(whole, *finer);
  else
    search_steps(whole.method.step / 2, 0, whole.worst_brick, whole);
  return {};
}

Trial LatticeSearch::run(double step, double brick) {
  const Trial trial = trials_.try_out(lattice(trials_.view(), step), brick,
                                      [&](const Trial& first) { return may_win(first, far_cost); });
  if (trial.accepted) accepted_.push_back(trial);
  return trial;
}

bool LatticeSearch::beats_best(const Trial& trial, double factor) const {
  if (!best_.accepted) return true;
  return std::min({trial.cost, trials_.cost_by(Integrator::porter_duff, trial),
                   trials_.cost_by(Integrator::midpoint, trial)}) <= factor * best_.cost;
}

bool LatticeSearch::may_win(const Trial& trial, double factor) const {
  if (const auto lattice = found()) return trial.cost <= factor * lattice->cost;
  return beats_best(trial, factor);
}

void LatticeSearch::search_steps(double first, double last, double brick,
                                 std::optional<Trial> coarse) {
  for (double step = first; step >= std::max(1.1 * last, narrowest_step); step /= 2) {
    const Trial fine = run(step, brick);
    if (fine.accepted) {
      if (coarse) widen(*coarse, fine);
      return;
    }
    if (!may_win(fine, 1)) return;
    coarse = fine;
  }
}

void LatticeSearch::widen(Trial coarse, Trial fine) {
  for (int i = 0; i < 3 && coarse.method.step > 1.12 * fine.method.step &&
                  coarse.cost < (1 - worth) * fine.cost;
       ++i) {
    const double steps = coarse.method.step / fine.method.step;
    const double order = std::log(coarse.rms / fine.rms) / std::log(steps);
    double ratio = order > 0.5 ? std::pow(trials_.target() / fine.rms, 1 / order) : 1;
    if (coarse.rms <= trials_.target())
      ratio = std::sqrt(steps);  // the RMS is small enough: one ray is off
    ratio = std::clamp(ratio, 1.1, 0.95 * steps);
    const Trial between = run(fine.method.step * ratio, fine.worst_brick);
    (between.accepted ? fine : coarse) = between;
  }
}

}  // namespace psivox
