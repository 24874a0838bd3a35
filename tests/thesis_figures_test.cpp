// Errors of approximations of Psi and zeta over segments whose end opacities are uniform in (0, 1).
// These are the figures that docs/method.md quotes for Moreland's fits (thesis eq. 64 and 65), to
// the digits given there.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "march/shader_math.h"
#include "smooth_ray.h"

namespace psivox {
namespace {

struct Difference {
  double rms = 0, max = 0;
};

/// Samples the middles of 400 x 400 cells of the unit square: `error` of the end opacities.
template <typename Error>
Difference over_opacities(Error error) {
  constexpr int n = 400;
  Difference d;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double e = std::abs(error((i + 0.5) / n, (j + 0.5) / n));
      d.rms += e * e;
      d.max = std::max(d.max, e);
    }
  d.rms = std::sqrt(d.rms / (n * n));
  return d;
}

/// Half a unit of the last digit quoted.
void expect(const std::string& what, const Difference& seen, double rms, double max) {
  std::printf("  %-36s RMS %.5f max %.4f\n", what.c_str(), seen.rms, seen.max);
  testing::Test::RecordProperty(what, std::to_string(seen.rms) + " " + std::to_string(seen.max));
  EXPECT_NEAR(seen.rms, rms, 0.5e-4) << what;
  EXPECT_NEAR(seen.max, max, 0.5e-3) << what;
}

double h(double t) { return -std::expm1(-t) / t; }
double attenuation(double opacity) { return -std::log1p(-opacity); }

TEST(ThesisFigures, PsiOfLinearAttenuation) {
  glsl::Math math;
  const auto error_of = [&](auto approximation) {
    return over_opacities([&](double a_f, double a_b) {
      const double x_f = attenuation(a_f), x_b = attenuation(a_b);
      const double zeta = std::exp(-(x_f + x_b) / 2);
      return approximation(x_f, x_b) - math.linear_psi(x_f, x_b, zeta).psi;
    });
  };
  expect("mean attenuation", error_of([](double x_f, double x_b) { return h((x_f + x_b) / 2); }),
         0.0565, 0.191);
  expect("weighted opacity", error_of([](double x_f, double x_b) {
           return h(-std::log(0.27 * std::exp(-x_b) + 0.73 * std::exp(-x_f)));
         }),
         0.0637, 0.378);
  expect("weighted attenuation 0.27",
         error_of([](double x_f, double x_b) { return h(0.27 * x_b + 0.73 * x_f); }), 0.0093,
         0.026);
  // Its greatest error lies in the middle of the last cell and grows towards the corner, where one
  // end is transparent and the other opaque; 0.0485 is the value on this grid.
  expect("weighted attenuation 0.30",
         error_of([](double x_f, double x_b) { return h(0.30 * x_b + 0.70 * x_f); }), 0.0058,
         0.0485);
}

TEST(ThesisFigures, PsiAndZetaOfLinearOpacity) {
  const auto psi_error = [&](double weight_f) {
    return over_opacities([=](double a_f, double a_b) {
      return psi_65(a_f, a_b, 1 - weight_f) - LinearOpacity{1 - a_f, 1 - a_b}.psi();
    });
  };
  expect("linear opacity, Psi of its mean", psi_error(0.5), 0.0591, 0.228);
  expect("linear opacity, Psi of eq. 65", psi_error(0.73), 0.0156, 0.065);
  constexpr double fitted_weight = 0.2864, fitted_bend = 0.1063;  // by least squares
  expect("linear opacity, Psi fitted", psi_error(1 - fitted_weight), 0.0150, 0.078);
  for (const double d : {-1e-3, 1e-3})
    EXPECT_GT(psi_error(1 - fitted_weight + d).rms, psi_error(1 - fitted_weight).rms);
  const auto zeta_error = [&](double bend) {
    return over_opacities([=](double a_f, double a_b) {
      return 1 - opacity_64(a_f, a_b, bend) - LinearOpacity{1 - a_f, 1 - a_b}.zeta();
    });
  };
  expect("linear opacity, zeta of its mean", zeta_error(0), 0.0286, 0.129);
  expect("linear opacity, zeta of eq. 64", zeta_error(0.108165), 0.0082, 0.038);
  expect("linear opacity, zeta fitted", zeta_error(fitted_bend), 0.0082, 0.039);
  for (const double d : {-1e-3, 1e-3})
    EXPECT_GT(zeta_error(fitted_bend + d).rms, zeta_error(fitted_bend).rms);
}

/// Checks that the rules are those approximations, as the GPU evaluates them, in double.
TEST(ThesisFigures, TheRulesAreThem) {
  glsl::Math math;
  double worst = 0;
  for (const double a_f : {0.01, 0.3, 0.77, 0.999})
    for (const double a_b : {0.02, 0.3, 0.6, 0.995}) {
      const double x_f = attenuation(a_f), x_b = attenuation(a_b);
      const glsl::Math::Segment s{x_f, (x_f + x_b) / 2, x_b, 1, (x_f + x_b) / 2};
      const double t = attenuation(0.27 * a_b + 0.73 * a_f);
      worst = std::max(worst, std::abs(math.linear_luminance(s).front - (1 - h(s.depth))));
      worst = std::max(worst, std::abs(math.psi_weighted(s).front - (1 - h(t))));
      const auto w = math.opacity_linear(s);
      const double zeta = 1 - (a_f + a_b) / 2 - 0.108165 * (a_b - a_f) * (a_b - a_f);
      worst = std::max(worst, std::abs(std::exp(-w.depth) - zeta));
      if (h(t) > zeta) worst = std::max(worst, std::abs(w.front - (1 - h(t))));
    }
  EXPECT_LE(worst, 1e-14);  // the error of 1 - h, for numbers of size 1
}

}  // namespace
}  // namespace psivox
