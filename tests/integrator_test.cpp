// Compares the formulas of shaders/math and shaders/integrators, in float and in double, with their
// definitions in long double.

#include "psivox/integrators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "rule_cases.h"

namespace psivox {
namespace {

template <typename Math>
struct Bounds;
// decay in float32: e^{-x} carries the rounding of x n ln 2 + r (2 ulp of r, |r| <= 0.35) and of q,
// s q (1 each), half-ulps of 6e-8: under 4e-7. Above its crossover 1 - h divides the cancelled sum
// by as little as 1/4.7 of it: 3.7 times as much error. minus_log_1m has six products and a
// division: 4e-7.
template <>
struct Bounds<glsl32::Math> {
  static constexpr wide decay = 4e-7L, log = 4e-7L, h = 6e-7L, one_minus_h = 2e-6L;
};
// In double glibc's exp, expm1 and log1p are within an ulp, 2.2e-16; 1 - h at the crossover 1e-3
// cancels a factor 2e3 of it.
template <>
struct Bounds<glsl::Math> {
  static constexpr wide decay = 5e-16L, log = 5e-16L, h = 1e-15L, one_minus_h = 1e-12L;
};

template <typename Math>
class ShaderMath : public testing::Test {
 protected:
  Math math;
};
TYPED_TEST_SUITE(ShaderMath, Precisions, PrecisionNames);

TYPED_TEST(ShaderMath, DecayAndOpacity) {
  using real = typename TypeParam::real;
  Worst e, a;
  for (const double value : log_spaced(1e-12, 1e6, 4000)) {
    const real x = real(value);
    const auto d = this->math.decay(x);
    e.see(relative(d.e, exact_decay(wide(x))), double(x));
    a.see(relative(d.a, exact_opacity(wide(x))), double(x));
  }
  report("decay.e", e);
  report("decay.a", a);
  EXPECT_LE(e.error, Bounds<TypeParam>::decay);
  EXPECT_LE(a.error, Bounds<TypeParam>::decay);
  EXPECT_EQ(this->math.decay(0).e, 1);
  EXPECT_EQ(this->math.decay(0).a, 0);
}

TYPED_TEST(ShaderMath, ShallowDecay) {
  using real = typename TypeParam::real;
  Worst near, far;
  for (const double value : log_spaced(1e-12, 1.49, 4000)) {
    const real x = real(value);
    Worst& worst = x < real(0.79) ? near : far;
    worst.see(relative(this->math.shallow_decay(x), exact_decay(wide(x))), double(x));
  }
  report("shallow_decay below 0.79", near);
  report("shallow_decay", far);
  EXPECT_LE(near.error, Bounds<TypeParam>::decay);
  // e^{-x} is a sum of 1 and terms up to x there, whose rounding it divides by up to 4.4, not 2.2
  EXPECT_LE(far.error, 2 * Bounds<TypeParam>::decay);
  EXPECT_EQ(this->math.shallow_decay(0), 1);
  EXPECT_GT(this->math.shallow_decay(real(1e30)), real(-1e-30));  // a weight, whatever the depth
}

// Off by 1 - e^{-x}'s rounding, at most 8 products' half-ulps of 6e-8 below 1, and 2e-7 of e^{-x}:
// weights are normalised, so that errors of 1 count.
TYPED_TEST(ShaderMath, DeepDecay) {
  using real = typename TypeParam::real;
  Worst worst;
  for (const double value : log_spaced(1e-12, 11.9, 4000)) {
    const real x = real(value);
    worst.see(std::abs(wide(this->math.deep_decay(x / 8)) - exact_decay(wide(x))), double(x));
  }
  report("deep_decay", worst);
  EXPECT_LE(worst.error, 2 * Bounds<TypeParam>::decay);
  EXPECT_EQ(this->math.deep_decay(0), 1);
  for (const real x : {real(1e30), real(-1e30)}) {  // a weight, whatever the depth
    EXPECT_GE(this->math.deep_decay(x), 0);
    EXPECT_LE(this->math.deep_decay(x), 1);
  }
}

TYPED_TEST(ShaderMath, MinusLogOneMinus) {
  using real = typename TypeParam::real;
  Worst worst;
  for (const double value : log_spaced(1e-12, 0.7499, 4000)) {
    const real v = real(value);
    worst.see(relative(this->math.minus_log_1m(v), -std::log1p(-wide(v))), double(v));
  }
  report("minus_log_1m", worst);
  EXPECT_LE(worst.error, Bounds<TypeParam>::log);
}

TYPED_TEST(ShaderMath, HomogeneousStep) {
  using real = typename TypeParam::real;
  Worst h, complement;
  for (const double value : log_spaced(1e-12, 1e6, 4000)) {
    const real t = real(value);
    const auto psi = this->math.homogeneous(t, this->math.decay(t).a);
    h.see(relative(psi.h, exact_h(wide(t))), double(t));
    complement.see(relative(psi.one_minus_h, exact_one_minus_h(wide(t))), double(t));
  }
  report("h", h);
  report("1 - h", complement);
  EXPECT_LE(h.error, Bounds<TypeParam>::h);
  EXPECT_LE(complement.error, Bounds<TypeParam>::one_minus_h);
  EXPECT_EQ(this->math.homogeneous(0, 0).h, 1);
  EXPECT_EQ(this->math.homogeneous(0, 0).one_minus_h, 0);
}

// --- rules ---------------------------------------------------------------------------------------

WideWeights weighted_opacity(wide x_f, wide x_b) {  // thesis eq. 65 and 53 to 56, as printed
  const wide zeta = exact_decay((x_f + x_b) / 2);
  // 1 - alpha_w, its logarithm by log-sum-exp where exp underflows
  const wide low = std::min(x_f, x_b), high = std::max(x_f, x_b);
  const wide w = x_f < x_b ? 0.27L : 0.73L;
  const wide t = low - std::log1p(-w * exact_opacity(high - low));
  const wide front = exact_one_minus_h(t);
  return {front, 0, exact_opacity((x_f + x_b) / 2) - front, zeta};
}

wide exact_balance(wide x) {  // 1 - y / sinh y
  const wide y = x / 2;
  if (y > 11000) return 1;
  if (y > 0.5L) return 1 - y / std::sinh(y);
  wide sum = 0, term = 1;  // (sinh y - y) / sinh y: 10 terms leave out 1e-25
  for (int n = 1; n <= 10; ++n) {
    term *= y * y / wide((2 * n) * (2 * n + 1));
    sum += term;
  }
  return sum / (1 + sum);
}

WideWeights balanced(wide x_f, wide x_b) {
  const wide e_f = exact_decay(x_f / 2), a_f = exact_opacity(x_f / 2);
  const wide e_b = exact_decay(x_b / 2), a_b = exact_opacity(x_b / 2);
  const wide p = std::min((exact_balance(x_f) + exact_balance(x_b)) / 2, a_b);
  return {a_f + e_f * p, 0, e_f * (a_b - p), e_f * e_b};
}

/// Checks for each rule that weights are never negative and sum to 1 - zeta of the depth it
/// returns.
template <typename Math, typename Rule>
Worst furnace(const Math& math, Rule rule, const std::vector<double>& xs) {
  using real = typename Math::real;
  Worst worst;
  for (const double f : xs)
    for (const double b : xs) {
      const auto w = rule(math, segment_of<Math>(real(f), real(b)));
      if (!(w.front >= 0 && w.middle >= 0 && w.back >= 0 && w.depth >= 0)) {
        ADD_FAILURE() << "negative or NaN at " << f << ", " << b;
        return worst;
      }
      const wide sum = wide(w.front) + wide(w.middle) + wide(w.back);
      worst.see(relative(sum, exact_opacity(wide(w.depth))), f, b);
    }
  return worst;
}

TYPED_TEST(ShaderMath, WeightsArePositiveAndSumToTheOpacity) {
  using Weights = typename TypeParam::Weights;
  using Segment = typename TypeParam::Segment;
  const std::vector<double> xs = log_spaced(1e-12, 1e4, 20);
  // Relative to 1 - zeta, which is stricter than "to rounding of 1". It allows decay's error and
  // the 3 to 5 roundings of the sum.
  const wide bound = 3 * Bounds<TypeParam>::decay;
#define PSIVOX_ROW(name, middle, exact, cost, help)                                   \
  {                                                                                   \
    const Worst worst = furnace(                                                      \
        this->math, [](TypeParam m, Segment s) -> Weights { return m.name(s); }, xs); \
    report("sum of " #name, worst);                                                   \
    EXPECT_LE(worst.error, bound) << #name;                                           \
  }
  PSIVOX_SEGMENT_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW
}

TYPED_TEST(ShaderMath, HomogeneousRulesAreTheirs) {
  using real = typename TypeParam::real;
  const auto s = segment_of<TypeParam>(real(0.25), real(1.75));
  const auto front = this->math.porter_duff(s);
  EXPECT_EQ(front.depth, real(0.25));
  EXPECT_NEAR(double(front.front), -std::expm1(-0.25), 1e-7);
  EXPECT_EQ(front.middle + front.back, 0);
  const auto middle = this->math.midpoint(s);
  EXPECT_EQ(middle.depth, real(1));
  EXPECT_NEAR(double(middle.middle), -std::expm1(-1.0), 1e-7);
  EXPECT_EQ(middle.front + middle.back, 0);
}

TYPED_TEST(ShaderMath, PsiWeightedAgainstItsFormula) {
  using real = typename TypeParam::real;
  WorstWeights worst;
  Worst zeta;
  for (const double f : log_spaced(1e-12, 1e4, 25))
    for (const double b : log_spaced(1e-12, 1e4, 25)) {
      const auto w = this->math.psi_weighted(segment_of<TypeParam>(real(f), real(b)));
      const auto e = weighted_opacity(wide(real(f)), wide(real(b)));
      worst.see(w, e.front, e.back, f, b);
      zeta.see(relative(w.depth, (wide(real(f)) + wide(real(b))) / 2), f, b);
    }
  worst.expect("psi_weighted", sizeof(real) == 4 ? 1e-5L : 1e-12L);  // in double: 1 - h's
  EXPECT_LE(zeta.error, sizeof(real) == 4 ? 2e-7L : 4e-16L);
}

// w_b = e_f (a_b - p) is a difference that passes through 0; min() keeps it there. Near that curve,
// and where both terms round to 1, no arithmetic bounds its relative error: the rounding of the
// inputs changes it as much. The tests bound the error relative to e_f a_b, the light that the back
// end could send, and so to the opacity; and the error relative to w_b if at least a tenth of it is
// left. Just above its crossover, balance() (p = 1 - q = y^2/6) carries the 3 roundings of q; half
// of them over a_b >= p/2 is 4e-6 in float (y = 1/2) and 1e-12 in double (y = 0.05).
TYPED_TEST(ShaderMath, PsiBalancedAgainstItsFormula) {
  using real = typename TypeParam::real;
  Worst front, back, back_of_all, of_opacity;
  for (const double f : log_spaced(1e-12, 1e4, 25))
    for (const double b : log_spaced(1e-12, 1e4, 25)) {
      const auto w = this->math.psi_balanced(segment_of<TypeParam>(real(f), real(b)));
      const auto e = balanced(wide(real(f)), wide(real(b)));
      front.see(relative(w.front, e.front), f, b);
      const wide all = exact_decay(wide(real(f)) / 2) * exact_opacity(wide(real(b)) / 2);
      if (e.back >= 0.1L * all) back.see(relative(w.back, e.back), f, b);
      if (all > least_float) back_of_all.see(std::abs(wide(w.back) - e.back) / all, f, b);
      if (all > least_float)
        of_opacity.see(std::abs(wide(w.back) - e.back) / (e.front + e.back), f, b);
    }
  report("psi_balanced w_f", front);
  report("psi_balanced w_b", back);
  report("psi_balanced w_b / (e_f a_b)", back_of_all);
  report("psi_balanced w_b / opacity", of_opacity);
  const bool single = sizeof(real) == 4;
  EXPECT_LE(front.error, single ? 1e-5L : 1e-12L);
  EXPECT_LE(back.error, single ? 1e-5L : 1e-11L);
  EXPECT_LE(back_of_all.error, single ? 4e-6L : 1e-12L);
  EXPECT_LE(of_opacity.error, single ? 1e-6L : 1e-14L);
}

/// The linear model of a segment whose depth is known better than its ends. The model is shifted to
/// that depth: its mean is exact, neither end is negative, and it is continuous as both ends
/// approach 0.
TYPED_TEST(ShaderMath, EndsAreShiftedToTheDepth) {
  using real = typename TypeParam::real;
  using Segment = typename TypeParam::Segment;
  const auto expect = [&](const Segment& segment, double front, double back) {
    const auto ends = this->math.shifted_ends(segment);
    EXPECT_NEAR(double(ends.front), front, 4e-7);
    EXPECT_NEAR(double(ends.back), back, 4e-7);
  };
  expect(Segment{1, 0, 3, 2, 4}, 2, 6);  // tau 1 and 3 over 2: unchanged
  expect(Segment{1, 0, 3, 2, 5}, 3, 7);  // shifted
  expect(Segment{1, 0, 3, 2, 1}, 0, 2);  // as steep as possible
  expect(Segment{3, 0, 1, 2, 1}, 2, 0);
  expect(Segment{0, 1, 0, 2, real(0.5)}, 0.5, 0.5);
  expect(Segment{real(1e-9), 1, 0, 2, real(0.5)}, 0.5, 0.5);  // their ratio is only rounding
  expect(Segment{0, 0, 0, 0, 0}, 0, 0);
}

}  // namespace
}  // namespace psivox
