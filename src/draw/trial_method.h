#pragma once

#include "march/marcher.h"

namespace psivox {

/// The view by a method, with the steps that its bricks take under it.
struct MethodView {
  View view;
  BrickSteps brick_steps;  ///< null: one step everywhere
};

/// The view by that method, its scene without a tolerance.
View with_method(View view, const Method& method);

/// The method with the least error, whatever it takes.
Method exact_method(const View& view);

/// Uniform steps, as lattices are first tried.
Method lattice(double step);

/// Time of one look-up of a method, with the rest of its turn of the loop, over that of
/// psi-balanced between uniform samples: measured on llvmpipe by psivox_bench_tolerance
/// (docs/performance.md).
double look_up_cost(const Method& method, const MethodView& marched);

}  // namespace psivox
