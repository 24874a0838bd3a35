#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "psivox/integrators.h"
#include "psivox/progress.h"

// Orders of convergence after Etiene et al. 2014: one length shrinks at a time, in media that are
// formulas with exact pictures.

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

/// The length that shrinks.
enum class Refined { step, voxel, pixel };

struct OrderRow {
  Refined refined = Refined::step;
  std::string rays;  ///< where they begin and end
  std::string way;   ///< the rule, and how else the picture is made
  Integrator rule = Integrator::psi_weighted;
  double K = 0;                       ///< extinction: optical depth over a width of the medium
  double expected = 0;                ///< expected order
  bool about = false;                 ///< the rule has an error that does not fall with the length
  double floor = 0;                   ///< errors below it are rounding
  std::vector<LengthError> errors{};  ///< RMS of the radiance, from coarse to fine

  std::vector<LengthError> fitted() const { return finest_four(errors, floor); }
  double observed() const { return fitted_order(fitted()); }
};

/// Orders of every segment rule in the uniform step, in widths of the medium: one ray without
/// voxels, RMS over 8 phases of the lattice.
std::vector<OrderRow> step_orders(const Progress& progress = {});

/// Orders in the size of voxels, in widths of the same medium in three dimensions. Errors are RMS
/// over the picture, against the medium itself.
std::vector<OrderRow> voxel_orders(const Progress& progress = {});

/// Orders in the size of pixels, in widths of the picture: one for the picture interpolated between
/// pixels, one for the mean of the pixels.
std::vector<OrderRow> pixel_orders(const Progress& progress = {});

}  // namespace psivox
