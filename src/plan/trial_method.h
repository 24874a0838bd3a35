#pragma once

#include "march/marcher.h"

namespace psivox {

/// A view by a method, with the steps that the method takes in each brick.
struct MethodView {
  View view;
  BrickSteps brick_steps;  ///< null: one step everywhere
  bool paired = false;     ///< the luminance is stored beside the density
};

/// The view by that method, without a tolerance.
View with_method(View view, const Method& method);

/// The method with the least error, whatever its cost.
Method exact_method(const View& view);

/// Uniform steps by the rule with which lattices are first tried: psi-balanced, or midpoint where
/// something emits, of which other rules look up two values a step.
Method lattice(const View& view, double step);

/// Time of one look-up of a method, with its share of the loop, relative to psi-balanced between
/// uniform samples. Measured on llvmpipe by psivox_bench_tolerance (docs/performance.md).
double look_up_cost(const Method& method, const MethodView& marched);

}  // namespace psivox
