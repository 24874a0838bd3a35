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

/// Rays that are marched before others.
constexpr std::size_t first_rays = 24;

/// Nothing is worth so many times the exact method's look-ups, even if that misses the tolerance.
constexpr double hopeless = 64;

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

/// How far beyond a limit an estimate from so many rays must be to leave a method.
double doubt(std::size_t rays) { return 1 + 3 / std::sqrt(double(rays)); }

double rms_of(double squares, std::size_t rays) {
  return std::hypot(std::sqrt(squares / (4 * double(rays))), arithmetic_error);
}

}  // namespace

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

std::vector<Trial> Trials::done() const {
  std::vector<Trial> trials;
  for (const Attempt& attempt : attempts_) trials.push_back(attempt.trial);
  return trials;
}

bool Trials::measure(Trial& trial, std::span<const std::optional<RayError>> errors,
                     std::size_t even) const {
  double all_squares = 0;
  trial.rays = 0;
  for (const std::optional<RayError>& error : errors) {
    if (!error) continue;
    ++trial.rays;
    all_squares += error->squares;
    trial.max = std::max(trial.max, error->largest);
  }
  double squares = 0, samples = 0, exact_samples = 0, all_exact_samples = 0;
  for (const int ray : pilot_.even_order().first(even)) {
    squares += errors[std::size_t(ray)]->squares;
    samples += errors[std::size_t(ray)]->samples;
    exact_samples += pilot_.exact_samples()[std::size_t(ray)];
  }
  for (const double of_ray : pilot_.exact_samples()) all_exact_samples += of_ray;
  trial.rms = rms_of(squares, even);
  // rays differ less in the ratio of their look-ups than in their number
  trial.samples = exact_samples > 0
                      ? samples * (all_exact_samples / exact_samples) / double(errors.size())
                      : samples / double(even);
  trial.cost = look_up_cost(trial.method, marched(trial)) * trial.samples;
  const bool within =
      rms_of(all_squares, errors.size()) <= target() && trial.max <= worst_ray * tolerance_;
  trial.accepted = within && trial.rms <= target();
  return within;
}

std::vector<int> Trials::suspects() const {
  std::vector<int> rays(last_errors_.size());
  std::iota(rays.begin(), rays.end(), 0);
  const auto error = [&](int ray) { return last_errors_[std::size_t(ray)]; };
  std::erase_if(rays, [&](int ray) { return error(ray) <= suspect_error * tolerance_; });
  std::stable_sort(rays.begin(), rays.end(), [&](int a, int b) { return error(a) > error(b); });
  rays.resize(std::min(rays.size(), most_suspects));
  return rays;
}

Trial Trials::run(const Method& method, double brick, const Trial& best, double part) {
  attempts_.push_back({{.method = method, .worst_brick = brick}, view_of(method, brick)});
  Trial& trial = attempts_.back().trial;
  const PixelMarch march = pilot_.march_of(attempts_.back().marched);
  const std::span<const int> order = pilot_.even_order();
  std::vector<std::optional<RayError>> errors(order.size());
  const auto march_some = [&](std::span<const int> rays) {
    std::vector<int> wanted;
    std::ranges::copy_if(rays, std::back_inserter(wanted),
                         [&](int ray) { return !errors[std::size_t(ray)]; });
    std::vector<RayError> found(wanted.size());
    pilot_.march(march, wanted, found);
    for (std::size_t i = 0; i < wanted.size(); ++i) errors[std::size_t(wanted[i])] = found[i];
  };
  const auto all = std::size_t(std::ceil(part * double(order.size())));
  bool may_win = true;
  for (std::size_t even = 0; may_win && even < all;) {
    if (even == first_rays) march_some(suspects());
    const std::size_t next = std::min(all, std::max(first_rays, 2 * even));
    march_some(order.subspan(even, next - even));
    even = next;
    may_win = measure(trial, errors, even) && trial.rms <= doubt(even) * target() &&
              !is_slower(trial, best, doubt(even));
  }
  for (std::size_t ray = 0; ray < errors.size(); ++ray)
    if (errors[ray]) last_errors_[ray] = errors[ray]->largest;
  trial.accepted = trial.accepted && may_win;
  return trial;
}

Trial Trials::run_exact() {
  const Method method = exact_method(view_);
  if (view_.medium.gradient) return run(method, 0, {});  // it misses something
  attempts_.push_back({{.method = method}, view_of(method, 0)});
  const std::span<const RayError> errors = pilot_.exact_errors();
  measure(attempts_.back().trial,
          std::vector<std::optional<RayError>>(errors.begin(), errors.end()), errors.size());
  return attempts_.back().trial;
}

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

const MethodView& Trials::marched(const Trial& trial) const {
  return std::ranges::find_if(attempts_,
                              [&](const Attempt& attempt) {
                                return attempt.trial.method == trial.method &&
                                       attempt.trial.worst_brick == trial.worst_brick;
                              })
      ->marched;
}

double Trials::cost_by(Integrator rule, const Trial& trial) const {
  MethodView by_rule = marched(trial);
  Method method = trial.method;
  method.integrator = by_rule.view.scene.integrator.emplace(rule);
  return look_up_cost(method, by_rule) * trial.samples;
}

bool Trials::is_slower(const Trial& trial, const Trial& best, double factor) const {
  if (!best.accepted) factor = hopeless;
  double cost = trial.cost;
  if (trial.method.sampling == Sampling::uniform && best.method.sampling != Sampling::uniform)
    cost = std::min(
        {cost, cost_by(Integrator::porter_duff, trial), cost_by(Integrator::midpoint, trial)});
  return best.cost > 0 && cost > factor * best.cost;
}

}  // namespace psivox
