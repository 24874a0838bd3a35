// Orders of convergence in the step, by the march in double over fields that are formulas. Checks
// what docs/method.md promises of each rule, and numbers computed by another program.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "march/formula_march.h"
#include "psivox/integrators.h"
#include "study/suite.h"

namespace psivox {
namespace {

struct Errors {
  double radiance = 0, transmittance = 0;  ///< RMS over phases
};

/// RMS over the phases of the lattice, for the segment from `first` to `last`.
Errors errors(Integrator rule, const SmoothRay& field, double first, double last, double h,
              int phases = 16, bool corrected = false) {
  const FormulaRay ray{[&](double x) { return field.tau(x); }, [&](double x) { return field.L(x); },
                       first, last};
  const double radiance = field.radiance(first, last);
  const double transmittance = std::exp(-field.depth(first, last));
  Errors sum;
  for (int i = 0; i < phases; ++i) {
    const FormulaSum m = march_formula(rule, ray, {h, h * (i + 0.37) / phases, corrected});
    const double dr = m.radiance - radiance;
    const double dt = std::exp(-m.optical_depth) - transmittance;
    sum.radiance += dr * dr / phases;
    sum.transmittance += dt * dt / phases;
  }
  return {std::sqrt(sum.radiance), std::sqrt(sum.transmittance)};
}

double order(Integrator rule, const SmoothRay& field, double first, double last,
             const std::vector<double>& steps, bool corrected = false) {
  std::vector<LengthError> radiance;
  for (const double h : steps)
    radiance.emplace_back(h, errors(rule, field, first, last, h, 16, corrected).radiance);
  const double result = fitted_order(radiance);
  std::printf("  %-16s K %-4g [%g, %g]: errors %.2e to %.2e, order %.3f\n", info(rule).name,
              field.K, first, last, radiance.front().second, radiance.back().second, result);
  testing::Test::RecordProperty(std::string(info(rule).name) + "_K" + std::to_string(field.K),
                                std::to_string(result));
  return result;
}

const std::vector<double> halving{1, 0.5, 0.25, 0.125, 0.0625};
// If a ray ends inside the medium, terms of several signs and orders meet: at coarse steps they can
// cancel.
const std::vector<double> fine_steps{1.0 / 8, 1.0 / 16, 1.0 / 32, 1.0 / 64, 1.0 / 128};

class Convergence : public testing::TestWithParam<double> {
 protected:
  SmoothRay field{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(K, Convergence, testing::Values(0.3, 3.0, 30.0));

constexpr double far = 9 * 8;  // where exp(-s^2) is 7e-36: vacuum

/// The rules with second order wherever a ray begins and ends.
constexpr Integrator second_order[] = {Integrator::midpoint,         Integrator::average,
                                       Integrator::linear_luminance, Integrator::opacity_linear,
                                       Integrator::psi_weighted,     Integrator::psi_exact,
                                       Integrator::linear_source};

TEST_P(Convergence, FromVacuumToVacuum) {
  for (const Integrator rule : second_order)
    EXPECT_GE(order(rule, field, -far, far, halving), 1.9) << info(rule).name;
  EXPECT_GE(order(Integrator::porter_duff, field, -far, far, halving), 1.9);
  // At K 30 a step of 1 is up to 3.75 optical depths; asymptotic behaviour starts at 1/2.
  std::vector<double> steps = halving;
  if (GetParam() == 30) steps.erase(steps.begin());
  EXPECT_GE(order(Integrator::psi_balanced, field, -far, far, steps), 3.8);
}

// psi-fit and psi-table have no order of their own. Their share of the back end is off by at most d
// however short the step; psi_rules_test measures d. That changes the picture by sum T (1 - zeta) d
// |L_f - L_b| <= d max|L_f - L_b| <= d h 0.6 1.3/8.
TEST_P(Convergence, ApproximationsFollowPsiExact) {
  const double first = -0.6 * 8 + 0.0123, last = 0.9 * 8 - 0.0077;
  const std::pair<Integrator, double> rules[] = {{Integrator::psi_fit, 4.7e-3},
                                                 {Integrator::psi_table, 1.1e-4}};
  for (const auto& [rule, d] : rules)
    for (const bool inside : {false, true}) {
      const double from = inside ? first : -far, to = inside ? last : far;
      order(rule, field, from, to, inside ? fine_steps : halving);
      for (const double h : inside ? fine_steps : halving)
        EXPECT_NEAR(errors(rule, field, from, to, h).radiance,
                    errors(Integrator::psi_exact, field, from, to, h).radiance, d * h * 0.0975)
            << info(rule).name << ' ' << h;
    }
}

TEST_P(Convergence, PorterDuffIsMidpointFromVacuumToVacuum) {
  for (const double h : {2.0, 1.0, 0.5, 0.25}) {
    const double a = errors(Integrator::porter_duff, field, -far, far, h, 64).radiance;
    const double b = errors(Integrator::midpoint, field, -far, far, h, 64).radiance;
    // The same sums over lattices that differ by half a step. They differ only because the first
    // and last steps here are cut at the ray's ends, in vacuum.
    EXPECT_NEAR(a / b, 1, 1e-3) << h;
  }
}

TEST_P(Convergence, FromInside) {
  // The camera at s = -0.6 and the box's face at s = 0.9, both off every lattice.
  const double first = -0.6 * 8 + 0.0123, last = 0.9 * 8 - 0.0077;
  for (const Integrator rule : second_order)
    EXPECT_GE(order(rule, field, first, last, fine_steps), 1.9) << info(rule).name;
  EXPECT_GE(order(Integrator::psi_balanced, field, first, last, fine_steps), 1.9);
  EXPECT_NEAR(order(Integrator::porter_duff, field, first, last, fine_steps), 1.0, 0.15);
}

TEST_P(Convergence, EndCorrectionsKeepTheOrderFromInside) {
  const double first = -0.6 * 8 + 0.0123, last = 0.9 * 8 - 0.0077;
  // At K 30 a step of 1/4 is up to one optical depth: asymptotic behaviour starts at 1/8. At K 0.3
  // the errors below 1/32 are no larger than rounding.
  std::vector<double> steps{0.25, 0.125, 0.0625, 0.03125};
  if (GetParam() == 30) steps = {0.125, 0.0625, 0.03125, 0.015625};
  EXPECT_GE(order(Integrator::psi_balanced, field, first, last, steps, true), 3.8);
  EXPECT_GE(order(Integrator::psi_balanced, field, -far, 0.25 * 8 + 0.0123, steps, true), 3.8);
}

TEST_P(Convergence, IntoTheBoxFace) {
  // From vacuum to the face of a cropped box in the middle of the medium.
  const double last = 0.25 * 8 + 0.0123;
  for (const Integrator rule : second_order)
    EXPECT_GE(order(rule, field, -far, last, fine_steps), 1.9) << info(rule).name;
  EXPECT_GE(order(Integrator::psi_balanced, field, -far, last, fine_steps), 1.9);
  // At K 30 the face is invisible: this is vacuum to vacuum.
  const double expected = GetParam() == 30 ? 2.0 : 1.0;
  EXPECT_NEAR(order(Integrator::porter_duff, field, -far, last, fine_steps), expected, 0.15);
}

TEST_P(Convergence, ConstantLuminanceIsFurnaceExact) {
  const FormulaRay ray{[&](double x) { return field.tau(x); }, [](double) { return 1.0; }, -5, 60};
  for (const IntegratorInfo& rule : integrators) {
    if (!is_segment_rule(rule.id)) continue;
    for (const double h : {0.1, 1.0, 7.3, 100.0}) {
      const FormulaSum m = march_formula(rule.id, ray, {h, 0.3 * h});
      EXPECT_NEAR(m.radiance, -std::expm1(-m.optical_depth), 1e-13) << rule.name << ' ' << h;
    }
  }
}

/// Computed by another program in float64: 144 steps over 18, RMS over the lattice's phases. Given
/// to its two digits.
TEST(ConvergenceTable, OfAnotherProgram) {
  struct Row {
    Integrator rule;
    std::array<double, 3> error;  // K 0.3, 3, 30
  };
  const Row table[] = {{Integrator::porter_duff, {3.4e-5, 6.6e-4, 3.2e-4}},
                       {Integrator::midpoint, {3.4e-5, 6.6e-4, 3.2e-4}},
                       {Integrator::psi_weighted, {1.9e-4, 1.7e-4, 1.5e-3}},
                       {Integrator::psi_exact, {2.5e-4, 7.8e-5, 1.8e-3}},
                       {Integrator::psi_balanced, {1.6e-7, 4.3e-7, 7.8e-6}}};
  constexpr std::array<double, 3> extinctions{0.3, 3, 30};
  for (const Row& row : table)
    for (std::size_t i = 0; i < 3; ++i) {
      const double seen = errors(row.rule, SmoothRay{extinctions[i]}, -far, far, 1, 64).radiance;
      std::printf("  %-16s K %-4g %.3e (page: %.1e)\n", info(row.rule).name, extinctions[i], seen,
                  row.error[i]);
      EXPECT_NEAR(seen / row.error[i], 1, 0.05) << info(row.rule).name << ' ' << extinctions[i];
    }
}

}  // namespace
}  // namespace psivox
