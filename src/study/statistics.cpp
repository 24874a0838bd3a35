#include <algorithm>
#include <cmath>
#include <numeric>

#include "psivox/error.h"
#include "psivox/study.h"

namespace psivox {
namespace {

/// Channels first to last - 1 of both pictures.
Deviation deviation(const Image& a, const Image& b, std::size_t first, std::size_t last) {
  Deviation d;
  std::vector<double> absolute;
  double sum = 0, squares = 0;
  const std::size_t pixels = a.rgba().size() / 4;
  absolute.reserve(pixels * (last - first));
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t c = first; c < last; ++c) {
      const double value = double(a.rgba()[4 * i + c]) - double(b.rgba()[4 * i + c]);
      if (!std::isfinite(value)) {
        ++d.not_finite;
        continue;
      }
      sum += value;
      squares += value * value;
      absolute.push_back(std::abs(value));
      if (absolute.back() <= d.max) continue;
      d.max = absolute.back();
      d.max_x = int(i % std::size_t(a.width));
      d.max_y = int(i / std::size_t(a.width));
    }
  if (absolute.empty()) return d;
  d.rms = std::sqrt(squares / double(absolute.size()));
  d.mean = sum / double(absolute.size());
  d.p99 = percentile(std::move(absolute), 0.99);
  return d;
}

Spread spread(const StudyPoint& point, double TimeSample::*member) {
  std::vector<double> values;
  for (const TimeSample& time : point.times) values.push_back(time.*member);
  return spread_of(std::move(values));
}

}  // namespace

double PictureError::rms() const {
  return std::sqrt((3 * radiance.rms * radiance.rms + alpha.rms * alpha.rms) / 4);
}

PictureError picture_error(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height)
    throw Error(ExitCode::input, "pictures of different sizes cannot be compared");
  return {deviation(a, b, 0, 3), deviation(a, b, 3, 4)};
}

double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double rank = std::ceil(fraction * double(values.size()));
  const auto i = std::size_t(std::clamp(rank, 1.0, double(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(i), values.end());
  return values[i];
}

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back()};
}

Spread wall_ms(const StudyPoint& point) { return spread(point, &TimeSample::wall_ms); }
Spread gpu_ms(const StudyPoint& point) { return spread(point, &TimeSample::gpu_ms); }
Spread cpu_ms(const StudyPoint& point) { return spread(point, &TimeSample::cpu_ms); }

std::vector<std::size_t> pareto_front(const std::vector<Cost>& costs, double margin) {
  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return costs[a].time != costs[b].time ? costs[a].time < costs[b].time
                                          : costs[a].error < costs[b].error;
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order)
    if (front.empty() || costs[i].error < (1 - margin) * costs[front.back()].error)
      front.push_back(i);
  return front;
}

}  // namespace psivox
