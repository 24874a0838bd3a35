#include <cmath>

#include "march/formula_march.h"
#include "psivox/statistics.h"
#include "study/orders.h"
#include "study/smooth_ray.h"
#include "study/variant.h"

namespace psivox {
namespace {

/// The ends of a ray. The medium is 8 units of x wide.
struct RayEnds {
  const char* name;
  double first, last;
  bool inside;
};
constexpr RayEnds ray_ends[] = {
    {"vacuum to vacuum", -48, 48, false},  // where e^-s^2 is 2e-16
    // the camera at s = -0.6, a face of the box at s = 0.9, both off every lattice
    {"from inside", -0.6 * 8 + 0.0123, 0.9 * 8 - 0.0077, true}};

double phase_rms(Integrator rule, const SmoothRay& medium, const RayEnds& ends, double h,
                 bool corrected) {
  constexpr int phases = 8;
  const FormulaRay ray{[&](double x) { return medium.tau(x); },
                       [&](double x) { return medium.L(x); }, ends.first, ends.last};
  const double exact = medium.radiance(ends.first, ends.last);
  ErrorSum sum;
  for (int i = 0; i < phases; ++i) {
    const double phase = h * (i + 0.37) / phases;
    sum.add(march_formula(rule, ray, {h, phase, corrected}).radiance - exact, sum.count);
  }
  return sum.rms();
}

OrderRow step_row(Integrator rule, double K, const RayEnds& ends, bool corrected) {
  OrderRow row;
  row.refined = Refined::step;
  row.rays = ends.name;
  row.rule = rule;
  row.way = rule_name({{.integrator = rule}}) + (corrected ? ", end corrections" : "");
  row.K = K;
  row.expected = rule == Integrator::psi_balanced ? (ends.inside && !corrected ? 2 : 4)
                 : rule == Integrator::porter_duff && ends.inside ? 1
                                                                  : 2;
  row.about = rule == Integrator::psi_fit || rule == Integrator::psi_table;
  row.floor = 1e-11;  // sums of up to 12,288 terms, each at most 1 and rounded by 1e-16
  const SmoothRay medium{K};
  for (double h = 1; h >= 1.0 / 128; h /= 2)
    row.errors.emplace_back(h / medium.scale, phase_rms(rule, medium, ends, h, corrected));
  return row;
}

}  // namespace

std::vector<OrderRow> step_orders(const Progress& progress) {
  std::vector<OrderRow> rows;
  const double all = 2 * 3 * 12;
  for (const RayEnds& ends : ray_ends)
    for (const double K : {0.3, 3.0, 30.0})
      for (const IntegratorInfo& rule : integrators) {
        if (!is_segment_rule(rule.id)) continue;
        rows.push_back(step_row(rule.id, K, ends, false));
        if (rule.id == Integrator::psi_balanced && ends.inside)
          rows.push_back(step_row(rule.id, K, ends, true));
        if (progress) progress(double(rows.size()) / all);
      }
  return rows;
}

}  // namespace psivox
