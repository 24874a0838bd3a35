#include "draw/trial_method.h"

#include <algorithm>

#include "march/end_corrections.h"

namespace psivox {
namespace {

bool depth_alone(const Medium& medium) {
  return medium.source == LuminanceSource::constant && !medium.transfer && !medium.emission;
}

double cell_cost(const Medium& medium, bool paired) {
  // the function's knots cut cells into pieces; one look-up may read the luminance too
  if (medium.transfer) return paired ? 2.4 : 1.6;
  if (medium.emission) return 1.3;
  return depth_alone(medium) ? 1.15 : 1;
}

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

Method lattice(double step) {
  return {.integrator = Integrator::psi_balanced, .sampling = Sampling::uniform, .step = step};
}

double look_up_cost(const Method& method, const MethodView& marched) {
  if (method.sampling == Sampling::uniform) return lattice_cost(method, marched);
  return cell_cost(marched.view.medium, marched.paired) * std::max(1.0, method.segments / 2.0);
}

}  // namespace psivox
