#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "psivox/integrators.h"
#include "study/results.h"

// The precision suite: scenes whose truth is known, every rule's error in them, and what must hold.

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

struct OrderRow {
  std::string scene, way;             ///< the rule and the sampling
  double expected = 0;                ///< expected order; 0: none
  double floor = 0;                   ///< errors below it are rounding
  std::vector<LengthError> errors{};  ///< RMS of the radiance, from coarse to fine
  double scatter = 0.35;              ///< how far the observed order may be from the expected one

  std::vector<LengthError> fitted() const { return finest_four(errors, floor); }
  double observed() const { return fitted_order(fitted()); }
  bool is_measured() const { return fitted().size() > 2; }
  /// Whether there is an order to hold: an expected one, and enough errors above rounding.
  bool is_held() const { return expected > 0 && is_measured(); }
  bool holds() const { return !is_held() || std::abs(observed() - expected) <= scatter; }
  /// A sentence that says that it does not hold.
  std::string miss() const;
};

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
  double tent = 0;                ///< half-width of the function's tents
  bool touches_jump = false;
};

/// Moreland's picture of two spheres (2004, fig. 1.10): red before blue along z, both dense in the
/// middle; they touch.
struct Spheres {
  Field density, color;
};
Spheres thesis_spheres();

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
  std::vector<SuiteRow> rows;
  std::vector<OrderRow> orders;  ///< over the steps or the segments of a cell
  std::uint64_t faults = 0;      ///< values that are NaN or Inf, and rays that stood still
  /// What is not as it must be, one sentence each.
  std::vector<std::string> misses() const;
};

/// Writes numbers and the page. Returns its first sentence. Throws Error(verification) if
/// something misses, when all is written.
std::string write_suite(const std::vector<SuiteResult>& results, const std::string& renderer,
                        const std::filesystem::path& folder);

}  // namespace psivox
