#include "plan/trial_method.h"

#include <algorithm>

#include "march/explain.h"

namespace psivox {
namespace {

bool depth_alone(const Medium& medium) {
  return medium.source == LuminanceSource::constant && !medium.transfer && !medium.emission;
}

double cell_cost(const Medium& medium, bool paired) {
  // the function's knots cut cells into pieces; one look-up may read the luminance too
  if (medium.transfer) return paired ? 3.5 : 1.6;
  if (medium.emission) return 1.3;
  return depth_alone(medium) ? 1.15 : 1;
}

/// Cost of a lit function's cell that is not cut at its knots: with one linear segment, and for
/// each further one.
constexpr double lit_segment_cost = 1.9, next_segment_cost = 0.45;

/// End corrections always look up slopes, needed or not.
constexpr double corrections_cost = 1.3;
constexpr double brick_steps_cost = 1.4;

double lattice_cost(const Method& method, const MethodView& marched) {
  double cost = depth_alone(marched.view.medium) ? 1 : info(method.integrator).lattice_cost;
  if (has_end_corrections(marched.view)) cost = corrections_cost;
  return marched.brick_steps ? brick_steps_cost * cost : cost;
}

}  // namespace

View with_method(View view, const Method& method) {
  view.scene = with_method(std::move(view.scene), method);
  return view;
}

Method exact_method(const View& view) {
  // with a gradient the attenuation along a cell is not a cubic
  if (view.medium.gradient) return {.integrator = Integrator::psi_exact, .segments = 32};
  if (!view.scene.composites()) return {.integrator = Integrator::psi_weighted, .segments = 1};
  return {.integrator = Integrator::cell_exact, .segments = 1};
}

Method lattice(const View& view, double step) {
  return {.integrator = view.medium.emission ? Integrator::midpoint : Integrator::psi_balanced,
          .sampling = Sampling::uniform,
          .step = step};
}

double look_up_cost(const Method& method, const MethodView& marched) {
  if (method.sampling == Sampling::uniform) return lattice_cost(method, marched);
  const Scene& scene = marched.view.scene;
  if (marched.paired && marched.view.medium.transfer && !is_cell_rule(method.integrator) &&
      !scene.split_knots)
    return lit_segment_cost + next_segment_cost * (method.segments - 1);
  return cell_cost(marched.view.medium, marched.paired) * std::max(1.0, method.segments / 2.0);
}

}  // namespace psivox
