#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace psivox {

/// The smallest value that at least `fraction` of the values do not exceed; 0 if there are none.
inline double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double place = std::ceil(fraction * double(values.size()));
  const auto i = std::size_t(std::clamp(place, 1.0, double(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(i), values.end());
  return values[i];
}

struct Spread {
  double median = 0, min = 0, max = 0;
  double lower = 0, upper = 0;  ///< the quartiles
};

/// Median and quartiles lie between sorted values linearly, at 1/2, 1/4 and 3/4 of the way from the
/// first to the last; all are 0 if there are none.
inline Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double fraction) {
    const double place = fraction * double(values.size() - 1);
    const auto i = std::size_t(place);
    return std::lerp(values[i], values[std::min(i + 1, values.size() - 1)], place - double(i));
  };
  return {at(0.5), values.front(), values.back(), at(0.25), at(0.75)};
}

/// Mean, RMS and largest magnitude of values that arrive one by one; all are 0 if there are none.
struct ErrorSum {
  double sum = 0, squares = 0;
  std::size_t count = 0;
  double max = 0;          ///< largest magnitude
  std::size_t max_at = 0;  ///< the least `at` of the values that have it

  void add(double value, std::size_t at) {
    sum += value;
    squares += value * value;
    ++count;
    take_max(std::abs(value), at);
  }
  ErrorSum& operator+=(const ErrorSum& other) {
    sum += other.sum;
    squares += other.squares;
    count += other.count;
    take_max(other.max, other.max_at);
    return *this;
  }
  double mean() const { return count ? sum / double(count) : 0; }
  double rms() const { return count ? std::sqrt(squares / double(count)) : 0; }

 private:
  void take_max(double magnitude, std::size_t at) {
    if (magnitude < max || (magnitude == max && at >= max_at)) return;
    max = magnitude;
    max_at = at;
  }
};

}  // namespace psivox
