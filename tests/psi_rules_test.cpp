// Compares the rules that differ only in Psi, in float and in double, with their definitions in
// long double: closed forms as printed if they exist, otherwise quadrature.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "psi_quadrature.h"
#include "psivox/integrators.h"
#include "rule_cases.h"

namespace psivox {
namespace {

template <typename Math>
class PsiRules : public testing::Test {
 protected:
  Math math;
};
TYPED_TEST_SUITE(PsiRules, Precisions, PrecisionNames);

/// Bound for every weight: the goal in float32; in double the error of 1 - h near its crossover.
template <typename real>
constexpr wide goal = sizeof(real) == 4 ? 1e-5L : 1e-12L;

TEST(PsiQuadrature, IsExact) {
  // Constant attenuation has closed forms. Otherwise doubling the panels must change nothing, and
  // the integrals must satisfy their identities.
  Worst closed, panels, identity;
  for (const double f : log_spaced(1e-6, 1e4, 3))
    for (const double b : log_spaced(1e-6, 1e4, 3)) {
      const LinearSegment s = linear_segment(f, b), fine = linear_segment(f, b, 160);
      panels.see(relative(s.psi, fine.psi), f, b);
      panels.see(relative(s.m, fine.m), f, b);
      if (f + b > 0) {
        panels.see(relative(s.front, fine.front), f, b);
        panels.see(relative(s.back, fine.back), f, b);
        identity.see(relative(s.front + s.back, exact_opacity((wide(f) + wide(b)) / 2)), f, b);
        identity.see(relative(f * s.rest + b * s.m, s.front + s.back), f, b);
      }
    }
  for (const double x : log_spaced(1e-6, 1e4, 20)) {
    const LinearSegment s = linear_segment(x, x);
    closed.see(relative(s.psi, exact_h(x)), x);
    if (x > 0) closed.see(relative(s.front, exact_one_minus_h(x)), x);
  }
  report("panels", panels);
  report("identities", identity);
  report("closed form", closed);
  EXPECT_LE(panels.error, 1e-16L);  // 1280 terms, 5e-20 each
  EXPECT_LE(identity.error, 1e-16L);
  EXPECT_LE(closed.error, 1e-16L);
}

TYPED_TEST(PsiRules, AverageIsHalfTheOpacityEach) {
  using real = typename TypeParam::real;
  Worst worst;
  for (const double f : log_spaced(1e-12, 1e4, 10))
    for (const double b : log_spaced(1e-12, 1e4, 10)) {
      const auto w = this->math.average(segment_of<TypeParam>(real(f), real(b)));
      EXPECT_EQ(w.front, w.back);
      worst.see(relative(w.front, exact_opacity((wide(real(f)) + wide(real(b))) / 2) / 2), f, b);
    }
  report("average", worst);
  EXPECT_LE(worst.error, goal<real>);
}

/// h(t) - e^{-depth}, from terms that are small if t is.
wide psi_minus_zeta(wide t, wide depth) {
  if (t < 1) return exact_opacity(depth) - exact_one_minus_h(t);
  return exact_h(t) - exact_decay(depth);
}

TYPED_TEST(PsiRules, LinearLuminanceIsTheHomogeneousPsi) {
  using real = typename TypeParam::real;
  WorstWeights worst;
  for (const double f : log_spaced(1e-12, 1e4, 25))
    for (const double b : log_spaced(1e-12, 1e4, 25)) {
      const wide t = (wide(real(f)) + wide(real(b))) / 2;
      worst.see(this->math.linear_luminance(segment_of<TypeParam>(real(f), real(b))),
                exact_one_minus_h(t), psi_minus_zeta(t, t), f, b);
    }
  worst.expect("linear_luminance", goal<real>);
}

/// Thesis eq. 64 and 65 as printed. `tau` is per unit of opacity, `units` per segment length.
struct OpacityLinear {
  wide depth, psi_depth;
};
OpacityLinear opacity_linear(wide tau_f, wide tau_b, wide units) {
  const wide a_f = exact_opacity(tau_f), a_b = exact_opacity(tau_b);
  const wide e_f = exact_decay(tau_f), e_b = exact_decay(tau_b);
  // ln(1 - alpha), from the opacities if they are small, otherwise from the transparencies
  const auto log_of = [](wide opacity, wide transparency) {
    return opacity < 0.5L ? std::log1p(-opacity) : std::log(transparency);
  };
  const wide bend = 0.108165L * (a_b - a_f) * (a_b - a_f);
  const wide bend_e = 0.108165L * (e_b - e_f) * (e_b - e_f);
  return {-units * log_of((a_b + a_f) / 2 + bend, (e_b + e_f) / 2 - bend_e),
          -units * log_of(0.27L * a_b + 0.73L * a_f, 0.27L * e_b + 0.73L * e_f)};
}

// Psi - zeta passes through 0 (and is cut there). Near it only the error relative to the opacity
// has a bound; w_b's own error has one if at least a tenth of Psi is left, a tenfold cancellation.
TYPED_TEST(PsiRules, OpacityLinearAgainstItsFormula) {
  using real = typename TypeParam::real;
  for (const double unit : {1.0, 0.125, 3.0}) {
    TypeParam own;
    own.opacity_unit = real(unit);
    Worst depth, front, back, of_opacity;
    // e^{-tau U} exists in long double up to a depth of 11,000
    for (const double f : log_spaced(1e-12, 1e4 / std::max(unit, 1.0), 20))
      for (const double b : log_spaced(1e-12, 1e4 / std::max(unit, 1.0), 20)) {
        const auto w = own.opacity_linear(segment_of<TypeParam>(real(f), real(b)));
        const OpacityLinear e =
            opacity_linear(wide(real(f)) * wide(unit), wide(real(b)) * wide(unit), 1 / wide(unit));
        const wide opacity = exact_opacity(e.depth);
        const wide e_front = std::min(exact_one_minus_h(e.psi_depth), opacity);
        const wide psi = exact_h(e.psi_depth);
        const wide e_back = std::max(psi_minus_zeta(e.psi_depth, e.depth), 0.0L);
        depth.see(relative(w.depth, e.depth), f, b);
        front.see(relative(w.front, e_front), f, b);
        if (e_back >= 0.1L * std::min(psi, opacity)) back.see(relative(w.back, e_back), f, b);
        if (opacity > 0) of_opacity.see(std::abs(w.back - e_back) / opacity, f, b);
      }
    report("opacity_linear depth", depth);
    report("opacity_linear w_f", front);
    report("opacity_linear w_b", back);
    report("opacity_linear w_b / opacity", of_opacity);
    EXPECT_LE(depth.error,
              sizeof(real) == 4 ? 1e-6L : 2e-15L);  // the error of minus_log_1m and of its argument
    EXPECT_LE(front.error, goal<real>);
    EXPECT_LE(back.error, goal<real>);
    EXPECT_LE(of_opacity.error, sizeof(real) == 4 ? 2e-6L : 1e-12L);
  }
}

TYPED_TEST(PsiRules, OpacityLinearIsExactWhereTheEndsAreEqual) {
  // Homogeneous: both fits give the attenuation itself, for any unit.
  using real = typename TypeParam::real;
  for (const double unit : {1.0, 0.125, 3.0})
    for (const real x : {real(1e-6), real(0.3), real(1), real(7), real(500)}) {
      TypeParam own;
      own.opacity_unit = real(unit);
      const auto w = own.opacity_linear(segment_of<TypeParam>(x, x));
      EXPECT_LE(relative(w.depth, x), sizeof(real) == 4 ? 2e-7L : 4e-16L);
      EXPECT_LE(relative(w.front, exact_one_minus_h(x)), goal<real>);
    }
}

/// The worst ends for closed forms and series: nearly equal ones, ones near the crossover, and one
/// end at 0.
std::vector<std::pair<double, double>> linear_cases() {
  std::vector<std::pair<double, double>> cases;
  for (const double f : log_spaced(1e-12, 1e4, 6))
    for (const double b : log_spaced(1e-12, 1e4, 6)) cases.emplace_back(f, b);
  for (const double x : log_spaced(1e-2, 1e4, 8))
    for (const double part : {0.0, 1e-7, 3e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.3}) {
      cases.emplace_back(x, x * (1 + part));
      cases.emplace_back(x * (1 + part), x);
    }
  for (const double x : {0.9, 0.999999, 1.0, 1.000001, 1.1, 2.0})
    for (const double other : {0.0, 1e-20, 0.01, 0.3, 0.7, 0.9999, 1.0, 1.5, 4.0, 20.0}) {
      cases.emplace_back(x, other);
      cases.emplace_back(other, x);
    }
  cases.emplace_back(1e4, 1e4 + 1e-3);
  cases.emplace_back(1e4 + 1e-3, 1e4);
  return cases;
}

TYPED_TEST(PsiRules, PsiExactAgainstQuadrature) {
  using real = typename TypeParam::real;
  WorstWeights worst;
  for (const auto& [f, b] : linear_cases()) {
    const LinearSegment e = linear_segment(wide(real(f)), wide(real(b)));
    worst.see(this->math.psi_exact(segment_of<TypeParam>(real(f), real(b))), e.front, e.back, f, b);
  }
  worst.expect("psi_exact", goal<real>);
}

TYPED_TEST(PsiRules, LinearSourceAgainstQuadrature) {
  using real = typename TypeParam::real;
  WorstWeights worst;
  for (const auto& [f, b] : linear_cases()) {
    const LinearSegment e = linear_segment(wide(real(f)), wide(real(b)));
    worst.see(this->math.linear_source(segment_of<TypeParam>(real(f), real(b))),
              wide(real(f)) * e.rest, wide(real(b)) * e.m, f, b);
  }
  worst.expect("linear_source", goal<real>);
}

/// The error of a rule that approximates psi-exact, in either precision.
struct Nearness {
  Worst psi, front, back;
};
template <typename Math, typename Rule>
Nearness nearness(Math& math, Rule rule, const char* name) {
  using real = typename Math::real;
  Nearness n;
  for (const double f : log_spaced(1e-12, 1e4, 24))
    for (const double b : log_spaced(1e-12, 1e4, 24)) {
      const auto s = segment_of<Math>(real(f), real(b));
      const auto w = rule(math, s), e = math.psi_exact(s);
      n.psi.see(std::abs(wide(w.front) - wide(e.front)), f, b);
      n.front.see(relative(w.front, e.front), f, b);
      n.back.see(relative(w.back, e.back), f, b);
    }
  report((std::string(name) + " |dPsi|").c_str(), n.psi);
  report((std::string(name) + " w_f").c_str(), n.front);
  report((std::string(name) + " w_b").c_str(), n.back);
  return n;
}

// The table's own error comes from the curvature over its cells. Measured on another grid of 25
// points per decade: |dPsi| 7.9e-5, w_f 9.5e-5 relative; w_b, almost 0 behind a dense front, 1.1e-2
// relative.
TYPED_TEST(PsiRules, PsiTableIsNearPsiExact) {
  const Nearness n = nearness(
      this->math, [](auto& m, const auto& s) { return m.psi_table(s); }, "psi_table");
  EXPECT_LE(n.psi.error, 8.5e-5L);
  EXPECT_LE(n.front.error, 1.1e-4L);
  EXPECT_LE(n.back.error, 1.5e-2L);
}

// tools/fit_psi prints 8.4e-4 for |dPsi|; the aim was 1e-3.
TYPED_TEST(PsiRules, PsiFitIsNearPsiExact) {
  const Nearness n = nearness(
      this->math, [](auto& m, const auto& s) { return m.psi_fit(s); }, "psi_fit");
  EXPECT_LE(n.psi.error, 8.5e-4L);
}

// Float32 against double: only arithmetic, as for every other rule.
TEST(PsiApproximations, FloatIsDouble) {
  glsl32::Math single;
  glsl::Math twice;
  const auto compare = [&](auto rule, const char* name) {
    WorstWeights worst;
    for (const double f : log_spaced(1e-12, 1e4, 24))
      for (const double b : log_spaced(1e-12, 1e4, 24)) {
        const auto e = rule(twice, segment_of<glsl::Math>(double(float(f)), double(float(b))));
        worst.see(rule(single, segment_of<glsl32::Math>(float(f), float(b))), e.front, e.back, f,
                  b);
      }
    worst.expect(name, goal<float>);
  };
  compare([](auto& m, const auto& s) { return m.psi_table(s); }, "psi_table");
  compare([](auto& m, const auto& s) { return m.psi_fit(s); }, "psi_fit");
}

/// Trilinear weights leave values like -2e-15 beside empty voxels; these must have no effect.
TYPED_TEST(PsiRules, RoundingBelowZeroIsVacuum) {
  using real = typename TypeParam::real;
  const real below = real(-2e-15);
  for (const auto& [f, b] : {std::pair{below, real(0)}, {real(0), below}, {below, below}}) {
    const auto s = segment_of<TypeParam>(f, b);
    const auto check = [](const auto& w, const char* rule) {
      for (const real v : {w.front, w.middle, w.back, w.depth})
        EXPECT_LE(std::abs(v), real(4e-15)) << rule;
    };
#define PSIVOX_ROW(name, middle, exact, cost, help) check(this->math.name(s), #name);
    PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
  }
}

/// Vacuum, walls, smallest numbers: every rule's weights are finite and within [0, 1 - zeta].
TYPED_TEST(PsiRules, HardCases) {
  using real = typename TypeParam::real;
  const real huge = real(1e30), least = std::numeric_limits<real>::min();
  const real values[] = {0,
                         std::numeric_limits<real>::denorm_min(),
                         least,
                         real(1e-20),
                         real(1),
                         std::nextafter(real(1), real(2)),
                         real(87),
                         real(1e4),
                         real(1e4) + real(1e-3),
                         real(3e7),
                         real(1e12),
                         huge};
  for (const real f : values)
    for (const real b : values) {
      const auto s = segment_of<TypeParam>(f, b);
      const auto check = [&](const auto& w, const char* rule) {
        const real opacity = this->math.decay(w.depth).a;
        for (const real v : {w.front, w.middle, w.back}) {
          EXPECT_TRUE(std::isfinite(v)) << rule << ' ' << f << ' ' << b;
          EXPECT_GE(v, 0) << rule << ' ' << f << ' ' << b;
          // 1 - zeta "to rounding": decay's own error
          EXPECT_LE(v, opacity * real(1 + 1e-6)) << rule << ' ' << f << ' ' << b;
        }
      };
#define PSIVOX_ROW(name, middle, exact, cost, help) check(this->math.name(s), #name);
      PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
    }
}

}  // namespace
}  // namespace psivox
