#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace psivox {

/// A length that is refined, and the error at that length.
using LengthError = std::pair<double, double>;

/// The slope of log error over log length, by least squares.
inline double fitted_order(const std::vector<LengthError>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [length, error] : points) {
    const double u = std::log(length), v = std::log(error);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

/// The points to fit an order to: the finest four whose error is above `floor`, from coarse to
/// fine.
inline std::vector<LengthError> finest_four(const std::vector<LengthError>& coarse_to_fine,
                                            double floor) {
  std::vector<LengthError> above;
  for (const LengthError& point : coarse_to_fine)
    if (point.second > floor) above.push_back(point);
  if (above.size() > 4) above.erase(above.begin(), above.end() - 4);
  return above;
}

}  // namespace psivox
