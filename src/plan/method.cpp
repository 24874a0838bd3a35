#include "plan/method.h"

#include <algorithm>

#include "march/light.h"

namespace psivox {
namespace {

constexpr double brick_steps_cost = 1.4;

/// Cost of a lit function's cell that is not cut at its knots: with one linear segment, and for
/// each further one.
constexpr double lit_segment_cost = 1.5, next_segment_cost = 0.65;

/// Of a cell that is one voxel: one texel is read, and one value classified.
constexpr double plain_voxel_cost = 0.75;

bool depth_alone(const Medium& medium) {
  return medium.source == LuminanceSource::constant && !medium.transfer && medium.emission.empty();
}

double cell_cost(const Medium& medium, bool paired) {
  // the function's knots cut cells into pieces; one look-up may read the luminance too
  if (medium.transfer) return paired ? 2.4 : 1.6;
  if (!medium.emission.empty()) return 1.3;
  return depth_alone(medium) ? 1.15 : 1;
}

}  // namespace

View with_method(View view, const Method& method) {
  view.scene = with_method(std::move(view.scene), method);
  return view;
}

bool has_plain_voxels(const Medium& medium) {
  return medium.nearest && medium.emission.empty() && medium.others.empty() &&
         (!medium.luminance || medium.lit);
}

Method exact_method(const View& view) {
  if (has_plain_voxels(view.medium)) return {.integrator = Integrator::midpoint, .segments = 1};
  // with a gradient the attenuation along a cell is not a cubic
  if (view.medium.gradient)
    return {.integrator = Integrator::psi_exact, .segments = gradient_segments};
  // a depth alone is Simpson's rule in a segment, unless the function has knots in it
  if (!view.scene.composites() && !(view.scene.attenuates() && view.medium.transfer))
    return {.integrator = Integrator::psi_weighted, .segments = 1};
  return {.integrator = Integrator::cell_exact, .segments = 1};
}

View exact_view(const View& view) {
  View exact = with_method(view, exact_method(view));
  exact.scene.early_termination = 0;
  exact.scene.filter = Filter::exact;
  exact.scene.texel = TexelType::float32;
  return exact;
}

Method lattice(const Medium& medium, double step) {
  const bool glows = !medium.emission.empty();
  return {.integrator = glows ? Integrator::midpoint : Integrator::psi_balanced,
          .sampling = Sampling::uniform,
          .step = step};
}

double look_up_cost(const MethodView& marched, bool paired) {
  const Medium& medium = marched.view.medium;
  const Method& method = marched.method;
  if (method.sampling == Sampling::uniform)
    return (depth_alone(medium) ? 1 : info(method.integrator).lattice_cost) *
           (marched.brick_steps ? brick_steps_cost : 1);
  if (has_plain_voxels(medium)) return plain_voxel_cost;
  if (paired && medium.transfer && !is_cell_rule(method.integrator) &&
      !marched.view.scene.split_knots)
    return lit_segment_cost + next_segment_cost * (method.segments - 1);
  return cell_cost(medium, paired) * std::max(1.0, method.segments / 2.0);
}

}  // namespace psivox
