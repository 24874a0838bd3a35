#include "draw/attempt.h"

#include <algorithm>
#include <cmath>

namespace psivox {

Attempt::Attempt(const Method& method, double worst_brick, const MethodView& marched,
                 const ErrorLimits& limits, Pilot& pilot)
    : trial_{.method = method, .worst_brick = worst_brick},
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

}  // namespace psivox
