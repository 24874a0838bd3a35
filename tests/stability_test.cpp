// Shows that printed formulas fail in float32 and that ours do not: docs/precision.md. The other
// hard cases have named tests in their own files.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <string>

#include "formula_march.h"
#include "made_fields.h"
#include "march_cases.h"
#include "psi_quadrature.h"

namespace psivox {
namespace {

/// The rules that define Psi, from which w_f = 1 - Psi and w_b = Psi - zeta.
constexpr Integrator psi_rules[] = {Integrator::linear_luminance, Integrator::psi_weighted,
                                    Integrator::psi_balanced,     Integrator::psi_exact,
                                    Integrator::psi_fit,          Integrator::psi_table};

void print(const std::string& what, double naive, double ours) {
  char text[64];
  std::snprintf(text, sizeof text, "naive %.2g, ours %.2g", naive, ours);
  testing::Test::RecordProperty(what, text);
  std::printf("  %-44s %s\n", what.c_str(), text);
}

double off(double value, double exact) { return std::abs(value / exact - 1); }

/// h(t) = (1 - e^{-t})/t as printed.
float printed_h(float t) { return (1 - std::exp(-t)) / t; }

/// 1 - Psi and Psi - zeta for equal ends, as printed.
struct PrintedWeights {
  float front, back;
  explicit PrintedWeights(float x) : front(1 - printed_h(x)), back(printed_h(x) - std::exp(-x)) {}
};

// Optical lengths from 1e-12 on: both weights are x/2. Ours: the bound of 1e-5 for each weight.
TEST(Stability, ThinSegmentsKeepBothWeights) {
  double naive = 0, ours = 0;
  for (double x = 1e-12; x < 1e-3; x *= 10) {
    const PrintedWeights printed(float{float(x)});
    const LinearSegment exact = linear_segment(float(x), float(x));
    naive = std::max(
        {naive, off(printed.front, double(exact.front)), off(printed.back, double(exact.back))});
    for (const Integrator rule : {Integrator::psi_weighted, Integrator::psi_exact}) {
      const RuleWeights w = rule_weights_float(rule, x, x);
      ours = std::max({ours, off(w.front, double(exact.front)), off(w.back, double(exact.back))});
    }
  }
  print("thin segments, weights, relative", naive, ours);
  EXPECT_GE(naive, 1);
  EXPECT_LE(ours, 1e-5);
}

// 10^5 segments of 1e-6, with L from 0 at the front to 1 at the back. The radiance has 10^5 terms,
// each rounded: a random walk of 6e-8 of the sum, 2e-5, and at most 6e-3. Ours sums as the march
// does, with the transmittance from the optical depth.
TEST(Stability, AHundredThousandThinSegments) {
  constexpr int n = 100'000;
  constexpr float x = 1e-6f;
  float naive = 0, naive_T = 1, ours = 0;
  double exact = 0;
  const PrintedWeights printed(x);
  const RuleWeights own = rule_weights_float(Integrator::psi_exact, double(x), double(x));
  const LinearSegment segment = linear_segment(x, x);
  for (int i = 0; i < n; ++i) {
    const float front = float(i) / n, back = float(i + 1) / n;
    naive += naive_T * (front * printed.front + back * printed.back);
    naive_T *= std::exp(-x);
    const double T = std::exp(-double(x) * i);
    ours += float(T) * (front * float(own.front) + back * float(own.back));
    exact += T * (double(front) * double(segment.front) + double(back) * double(segment.back));
  }
  print("1e5 thin segments, radiance, relative", off(naive, exact), off(ours, exact));
  EXPECT_GE(off(naive, exact), 0.05);
  EXPECT_LE(off(ours, exact), 2e-5);
}

// Weighted opacity (thesis eq. 65): -ln(1 - alpha_w) is infinite if the ends' opacities round to 1,
// and the back end loses all its weight. For equal ends the rule is exact.
TEST(Stability, OpaqueEndsHaveAFiniteWeightedDepth) {
  double naive = 0, ours = 0;
  for (const float x : {10.0f, 20.0f, 50.0f, 87.0f}) {
    const float alpha = 1 - std::exp(-x);
    const float t = -std::log(1 - (0.27f * alpha + 0.73f * alpha));
    EXPECT_EQ(std::isinf(t), x > 17);
    const double exact = double(linear_segment(x, x).back);
    naive = std::max(naive, off(printed_h(t) - std::exp(-x), exact));
    ours = std::max(ours, off(rule_weights_float(Integrator::psi_weighted, x, x).back, exact));
  }
  print("opaque ends, w_b of psi-weighted, relative", naive, ours);
  EXPECT_GE(naive, 0.99);
  EXPECT_LE(ours, 1e-5);
}

/// Psi of linear attenuation in float by the closed form as printed, with erf of the ends and a
/// guard of 1e-8 like VTK's.
float printed_psi(float x_f, float x_b) {
  if (std::abs(x_f - x_b) < 1e-8f) return printed_h(x_f);
  const float a = (x_b - x_f) / 2;  // > 0
  const float s = std::sqrt(a), p = x_f / (2 * s);
  return std::sqrt(std::numbers::pi_v<float>) / (2 * s) * std::exp(p * p) *
         (std::erf(p + s) - std::erf(p));
}

// Ends that differ by 1e-7 to 1e-6 of 1; large ends differ proportionally more.
TEST(Stability, NearlyEqualEnds) {
  double naive = 0, ours = 0;
  for (const float x : {0.1f, 1.0f, 3.0f})
    for (const float d : {1e-7f, 3e-7f, 1e-6f, 1e-5f, 1e-3f, 1e-2f}) {
      const float back = x + d;
      if (back == x) continue;
      const LinearSegment exact = linear_segment(x, back);
      naive = larger(naive, std::abs(printed_psi(x, back) - double(exact.psi)));
      const RuleWeights w = rule_weights_float(Integrator::psi_exact, x, back);
      ours = std::max(ours, std::abs(w.front - double(exact.front)));
    }
  print("nearly equal ends, Psi", naive, ours);
  EXPECT_TRUE(!(naive < 1e-2));
  EXPECT_LE(ours, 2.1e-6);
}

// A table over x/(1 + x), which rounds to 1 from 3e7 on: the index is one past the last entry.
TEST(Stability, TablesEndWithTheirLastEntry) {
  constexpr int entries = 128;
  int outside = 0;
  double ours = 0;
  for (const float x : {1e4f, 3e7f, 1e9f, 1e20f}) {
    outside += int(x / (1 + x) * entries) >= entries;
    const RuleWeights w = rule_weights_float(Integrator::psi_table, x, x);
    ours = std::max(ours, std::abs(w.front + w.back - 1));
  }
  print("huge lengths, table: entries outside; w_f + w_b - 1", outside, ours);
  EXPECT_GE(outside, 3);
  EXPECT_LE(ours, 2.4e-7);  // two roundings of 1
}

// D = 0: a formula that divides by the length has no value; a segment of no length has no effect.
TEST(Stability, NoLengthIsNothing) {
  const float depth = 0, length = 0;
  EXPECT_TRUE(std::isnan(depth / length));
  EXPECT_TRUE(std::isnan(printed_h(0)));
  for (const Integrator rule : psi_rules) {
    const RuleWeights w = rule_weights_float(rule, 0, 0);
    EXPECT_EQ(w.front, 0) << info(rule).name;
    EXPECT_EQ(w.back, 0) << info(rule).name;
    EXPECT_EQ(w.depth, 0) << info(rule).name;
  }
}

// With L = 0 at the front only w_b is visible. Behind opaque fronts it is almost 0, so only
// segments that transmit at least a tenth are tested; rules that fit Psi have their own tests.
TEST(Stability, OneDarkEnd) {
  double naive = 0, ours = 0;
  for (double x = 1e-7; x < 2; x *= 10) {
    const LinearSegment exact = linear_segment(float(x), float(x));
    naive = std::max(naive, off(PrintedWeights(float{float(x)}).back, double(exact.back)));
    for (const Integrator rule : {Integrator::psi_weighted, Integrator::psi_exact})
      ours = std::max(ours, off(rule_weights_float(rule, x, x).back, double(exact.back)));
  }
  print("dark front, radiance, relative", naive, ours);
  EXPECT_GE(naive, 0.1);
  EXPECT_LE(ours, 1e-5);
}

// --- pictures ------------------------------------------------------------------------------------

class StabilityGpu : public GpuTest {};

/// Largest difference, relative to the largest number of the exact picture.
double relative_difference(const Image& image, const Image& exact) {
  double worst = 0, scale = 0;
  for (std::size_t i = 0; i < image.rgba().size(); ++i) {
    if (i % 4 == 3) continue;
    worst = larger(worst, std::abs(double(image.rgba()[i]) - double(exact.rgba()[i])));
    scale = std::max(scale, double(exact.rgba()[i]));
  }
  return worst / scale;
}

Scene oblique_blobs() { return looking(small_scene(24), {95, 60, 70}, {20, 18, 16}, 40.0); }

// L up to 1e6, tau to match: a picture of about 1. The radiance of 70 cells, each with 20 roundings
// of 2^-24, random: 2e-6 of the largest pixel, 1e-5 at most. cell-exact has no step error.
TEST_F(StabilityGpu, BrightAndThin) {
  for (const double L : {1e6, 1e-6}) {
    const double K = 0.1 / std::max(L, 1.0);
    Scene scene = oblique_blobs();
    scene.extinction = K;
    scene.luminance_scale = L;
    scene.integrator = Integrator::cell_exact;
    const View view = view_of(scene, blobs(), Glow::density);
    const double ours = relative_difference(gl_picture(view), render_reference(view).image);
    const double naive = off(1 - std::exp(-float(K)), -std::expm1(-K));
    print("L " + std::to_string(L) + ", radiance, relative", naive, ours);
    EXPECT_LE(ours, 1e-5) << L;
    if (L > 1) {
      EXPECT_GE(naive, 0.1);
    }
  }
}

// Trilinear values that round below 0 times an extinction that makes their depth hugely negative:
// e^{-x} must not overflow at a node where the attenuation is 0.
TEST_F(StabilityGpu, RoundingTimesAHugeExtinction) {
  for (const double extinction : {1e18, 1e34}) {
    Scene scene = oblique_blobs();
    scene.resolution = {64, 64};
    scene.integrator = Integrator::cell_exact;
    scene.extinction = extinction;
    const Image image = gl_picture(view_of(scene, blobs(), Glow::density));
    expect_content(image, 0.1);
    EXPECT_EQ(compare_images(image, image).not_finite, 0u) << extinction;
  }
}

// A node's weight is an attenuation; times a luminance of the same size, float32 has no number.
TEST_F(StabilityGpu, GreatValuesThatGlow) {
  for (const float size : {1e18f, 1e20f, 1e30f}) {
    Scene scene = oblique_blobs();
    scene.resolution = {64, 64};
    scene.integrator = Integrator::cell_exact;
    scene.extinction = 1 / double(size);
    const auto value = [&](const glm::ivec3& v) { return size * blobs_at(glm::dvec3(v)); };
    const View view = view_of(scene, make_field({{0, 0, 0}, {39, 35, 31}}, value), Glow::density);
    EXPECT_LE(relative_difference(gl_picture(view), render_reference(view).image), 1e-5) << size;
  }
}

}  // namespace
}  // namespace psivox
