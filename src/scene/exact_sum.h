#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace psivox {

/// Rounds numbers to multiples of a power of two that is so large that sums of them have no
/// rounding. The sum is then the same in any order, so that several processes find the same bits as
/// one. `total`: no sum of magnitudes is larger; a number is rounded by less than 2^-52 of it.
class ExactSum {
 public:
  explicit ExactSum(double total)
      : unit_(std::ldexp(1.0, std::ilogb(std::max(total, least)) - 51)) {}

  double operator()(double number) const { return std::nearbyint(number / unit_) * unit_; }

 private:
  static constexpr double least = 1e-200;  // its unit is a normal number
  double unit_;
};

}  // namespace psivox
