#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

// Media that are formulas, with exact pictures.

namespace psivox {

/// Five-point Gauss-Legendre on [-1, 1].
inline constexpr std::array<double, 5> gauss_node{-0.906179845938664, -0.538469310105683, 0,
                                                  0.538469310105683, 0.906179845938664};
inline constexpr std::array<double, 5> gauss_weight{
    0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366, 0.236926885056189};

/// The integral of f over [a, b] in equal panels.
template <typename Function>
double gauss_sum(double a, double b, int panels, Function f) {
  const double h = (b - a) / panels;
  double sum = 0;
  for (int i = 0; i < panels; ++i)
    for (std::size_t n = 0; n < gauss_node.size(); ++n)
      sum += 0.5 * h * gauss_weight[n] * f(a + h * (i + 0.5 + 0.5 * gauss_node[n]));
  return sum;
}

/// A smooth ray: tau = K/scale e^{-s^2}, L = 1 + 0.6 sin(wave s + phase), s = x/scale. Its optical
/// depth is an error function.
struct SmoothRay {
  double K;          ///< optical depth of the whole ray over sqrt(pi)
  double scale = 8;  ///< x where s = 1
  double wave = 1.3, phase = 0.4;

  double tau(double x) const { return K / scale * std::exp(-x * x / (scale * scale)); }
  double L(double x) const { return 1 + 0.6 * std::sin(wave * x / scale + phase); }
  double depth(double a, double b) const {
    return K * std::sqrt(std::numbers::pi) / 2 * (std::erf(b / scale) - std::erf(a / scale));
  }
  /// The integral of L tau T dx from a to b. With panels of s = 1/64 the quadrature's relative
  /// error is below 1e-16 (the tenth derivative of a Gaussian of width 1 over a panel).
  double radiance(double a, double b) const {
    const int panels = int(std::ceil((b - a) / scale * 64));
    return gauss_sum(a, b, panels,
                     [&](double x) { return L(x) * tau(x) * std::exp(-depth(a, x)); });
  }
};

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
