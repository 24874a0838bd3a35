#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace psivox {

/// The smallest value that at least `fraction` of the values do not exceed; 0 if there are none.
inline double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double rank = std::ceil(fraction * double(values.size()));
  const auto i = std::size_t(std::clamp(rank, 1.0, double(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(i), values.end());
  return values[i];
}

struct Spread {
  double median = 0, min = 0, max = 0;
};

/// The median of an even number of values is the mean of the middle two; all are 0 if there are
/// none.
inline Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return {(values[(n - 1) / 2] + values[n / 2]) / 2, values.front(), values.back()};
}

}  // namespace psivox
