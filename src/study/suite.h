#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "psivox/integrators.h"
#include "study/results.h"

// The rules alone: orders of convergence, and the precision suite.

namespace psivox {

// Orders of convergence after Etiene et al. 2014: one length shrinks at a time, in media that are
// formulas with exact pictures.

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
  std::string rays;  ///< where they begin and end, or the name of a scene
  std::string way;   ///< the rule, and how else the picture is made
  Integrator rule = Integrator::psi_weighted;
  double K = 0;                       ///< extinction: optical depth over a width of the medium
  double expected = 0;                ///< expected order; 0: none
  bool about = false;                 ///< the rule has an error that does not fall with the length
  double floor = 0;                   ///< errors below it are rounding
  std::vector<LengthError> errors{};  ///< RMS of the radiance, from coarse to fine
  double scatter = 0.1;               ///< how far the observed order may be from the expected one

  std::vector<LengthError> fitted() const { return finest_four(errors, floor); }
  double observed() const { return fitted_order(fitted()); }
  bool is_measured() const { return fitted().size() > 2; }
  /// Whether there is an order to hold: an expected one, and enough errors above rounding.
  bool is_held() const { return expected > 0 && !about && is_measured(); }
  bool holds() const { return !is_held() || std::abs(observed() - expected) <= scatter; }
  /// A sentence that says that it does not hold.
  std::string miss() const;
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

// The suite: scenes whose truth is known, every rule's error in them, and what must hold.

/// What a scene's attenuation and luminance are like along a ray; the expected orders follow.
enum class Smoothness {
  kinks,  ///< continuous, with kinks at faces of cells or knots of the function
  cut,    ///< the same, and the camera is inside
  jumps,  ///< the function jumps
  rough,  ///< kinks closer together than most steps, or silhouettes: no order is expected
};

struct SuiteScene {
  std::string name;    ///< of its files too
  std::string medium;  ///< in words, for a reader who has not seen psivox
  Smoothness smoothness = Smoothness::kinks;
  std::vector<View> views;        ///< compared as one picture
  std::vector<Integrator> rules;  ///< between uniform samples
  std::vector<double> steps;      ///< [voxels]
  /// The exact value of `channel` at the end of a ray; empty: only the reference knows it.
  std::function<double(const WorldRay&)> truth{};
  int channel = 3;
  double tent = 0;  ///< half-width of the function's tents
  bool touches_jump = false;
};

/// The scenes of the suite. Their transfer functions are written to `folder`.
std::vector<SuiteScene> suite_scenes(bool full, const std::filesystem::path& folder);

/// The order of convergence that a method must show in a scene; 0: none.
double expected_order(const SuiteScene& scene, const Method& method);

/// Ends of the bins of the differences' histogram: 1e-1, 1e-2, ...
inline constexpr int suite_bins = 7;

struct SuiteRow {
  StudyPoint point;
  std::uint64_t rays = 0;
  double p999 = 0, max = 0;
  std::array<double, suite_bins> above{};  ///< fraction of the differences above 10^-1, 10^-2, ...
  double psnr() const { return -20 * std::log10(point.rms()); }  ///< with a peak of 1
};

/// Bounds on cell-exact. RMS 2e-6 and, of one cell, 5e-5 are what docs/method.md promises. In a
/// tent of half-width w an error e of the value is one of e/w of the attenuation at its top: at
/// most 2 e/w of the tent's depth d, and d e^-d <= 0.37. Below 1 the roundings of a value have RMS
/// e below 2^-24 and add up to 8 times that. Where a ray touches a jump, no bound on one pixel
/// holds.
struct ExactBound {
  double rms, max;
};
ExactBound exact_bound(const SuiteScene& scene);

struct SuiteResult {
  SuiteScene scene;
  double reference_bound = 0;  ///< the largest at any pixel
  double truth_error = 0;      ///< largest difference of the reference from `truth`
  std::vector<SuiteRow> rows;
  std::vector<OrderRow> orders;  ///< over the steps or the segments of a cell
  /// Pictures hold floats: a half unit in the last place of numbers below 1, for the picture and
  /// for its voxels each.
  double truth_bound() const { return reference_bound + 2 * 0x1p-24; }
  std::uint64_t faults = 0;  ///< values that are NaN or Inf, and rays that stood still
  /// What is not as it must be, one sentence each.
  std::vector<std::string> misses() const;
};

/// Writes tables, plots and the page. Returns its first sentence. Throws Error(verification) if
/// something misses, when all is written.
std::string write_suite(const std::vector<SuiteResult>& results, const std::vector<OrderRow>& rays,
                        const std::string& renderer, const std::filesystem::path& folder);

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
