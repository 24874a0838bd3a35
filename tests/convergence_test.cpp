// Errors of the march in double over fields that are formulas, beside other rules' and another
// program's. orders_test has the orders of convergence that docs/method.md promises of each rule.

#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "base/statistics.h"
#include "formula_march.h"
#include "psivox/integrators.h"
#include "smooth_ray.h"

namespace psivox {
namespace {

/// RMS of the radiance over the phases of the lattice, for the segment from `first` to `last`.
double rms(Integrator rule, const SmoothRay& field, double first, double last, double h,
           int phases = 16) {
  const FormulaRay ray{[&](double x) { return field.tau(x); }, [&](double x) { return field.L(x); },
                       first, last};
  ErrorSum sum;
  for (int i = 0; i < phases; ++i)
    sum.add(march_formula(rule, ray, {h, h * (i + 0.37) / phases}).radiance -
                field.radiance(first, last),
            sum.count);
  return sum.rms();
}

constexpr double far = 9 * 8;  // where exp(-s^2) is 7e-36: vacuum
constexpr std::array<double, 3> extinctions{0.3, 3, 30};

// psi-fit and psi-table have no order of their own. Their share of the back end is off by at most d
// however short the step; psi_rules_test measures d. That changes the picture by sum T (1 - zeta) d
// |L_f - L_b| <= d max|L_f - L_b| <= d h 0.6 1.3/8.
TEST(Convergence, ApproximationsFollowPsiExact) {
  struct Ends {
    double first, last, longest;  ///< of the ray, and of a step
  };
  for (const double K : extinctions)
    for (const auto& [rule, d] :
         {std::pair(Integrator::psi_fit, 4.7e-3), {Integrator::psi_table, 1.1e-4}})
      for (const Ends& ends :
           {Ends{-far, far, 1}, Ends{-0.6 * 8 + 0.0123, 0.9 * 8 - 0.0077, 1.0 / 8}})
        for (double h = ends.longest; h >= ends.longest / 16; h /= 2)
          EXPECT_NEAR(rms(rule, {K}, ends.first, ends.last, h),
                      rms(Integrator::psi_exact, {K}, ends.first, ends.last, h), d * h * 0.0975)
              << info(rule).name << " K " << K << ' ' << h;
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
  for (const Row& row : table)
    for (std::size_t i = 0; i < 3; ++i) {
      const double seen = rms(row.rule, {extinctions[i]}, -far, far, 1, 64);
      std::printf("  %-16s K %-4g %.3e (page: %.1e)\n", info(row.rule).name, extinctions[i], seen,
                  row.error[i]);
      EXPECT_NEAR(seen / row.error[i], 1, 0.05) << info(row.rule).name << ' ' << extinctions[i];
    }
}

}  // namespace
}  // namespace psivox
