#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "study/orders.h"
#include "study/results.h"

// The precision suite: scenes whose truth is known, every rule's error in them, and what must hold.

namespace psivox {

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
  double psnr() const { return -20 * std::log10(point.error.rms()); }  ///< with a peak of 1
};

/// A rule's measured order in a scene, over the steps or the segments of a cell.
struct SuiteOrder {
  Variant refinement;
  double expected = 0, observed = 0;
  int points = 0;  ///< errors above rounding, at most 4; fewer than 3 show no order
  bool holds() const;
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
  std::vector<SuiteOrder> orders;
  /// Pictures hold floats: a half unit in the last place of numbers below 1, for the picture and
  /// for its voxels each.
  double truth_bound() const { return reference_bound + 2 * 0x1p-24; }
  std::uint64_t faults = 0;  ///< values that are NaN or Inf, and rays that stood still
  /// What is not as it must be, one sentence each.
  std::vector<std::string> misses() const;
};

/// Whether a row of --orders is within a tenth of the expected order: its errors have no scatter.
bool ray_holds(const OrderRow& row);

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
