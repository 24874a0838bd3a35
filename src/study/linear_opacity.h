#pragma once

#include <cmath>

#include "study/orders.h"

namespace psivox {

/// A segment of length 1 whose transparency per unit length, e(u) = 1 - alpha(u), is linear
/// (Moreland 2004, "Improved Approximation").
struct LinearOpacity {
  double e_f, e_b;

  /// int_0^u ln e: the difference of e ln e - e between its ends, over the slope.
  double log_transparency(double u) const {
    const double slope = e_b - e_f, e = e_f + slope * u;
    if (std::abs(slope) < 1e-9) return u * std::log(e_f);
    return (e * std::log(e) - e - e_f * std::log(e_f) + e_f) / slope;
  }
  double zeta() const { return std::exp(log_transparency(1)); }
  double psi() const {
    return gauss_sum(0, 1, 4, [&](double u) { return std::exp(log_transparency(u)); });
  }
};

/// Moreland's approximations by the opacities of both ends: eq. 64, opacity, and 65, Psi.
inline double opacity_64(double a_f, double a_b, double bend = 0.108165) {
  return 0.5 * (a_f + a_b) + bend * (a_b - a_f) * (a_b - a_f);
}
inline double psi_65(double a_f, double a_b, double weight = 0.27) {
  const double t = -std::log1p(-(weight * a_b + (1 - weight) * a_f));
  return -std::expm1(-t) / t;
}

}  // namespace psivox
