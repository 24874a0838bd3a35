#pragma once

#include "march/march_double.h"
#include "march/marcher.h"

namespace psivox {

/// A view by a method, with the steps that the method takes in each brick.
struct MethodView {
  Method method;
  View view;
  BrickSteps brick_steps{};  ///< null: one step everywhere
};

/// The view by that method, without a tolerance.
View with_method(View view, const Method& method);

/// The method with the least error, whatever its cost.
Method exact_method(const View& view);

/// The view by the exact method, without early termination. Its only error is arithmetic, and
/// plan_march takes it for the truth.
View exact_view(const View& view);

/// Whether the medium of a voxel is homogeneous, so that a homogeneous step through it is exact.
bool has_plain_voxels(const Medium& medium);

/// Uniform steps of so many voxels by `psi-balanced`, Moreland's weighted opacity; with emission by
/// `midpoint`, which looks up less there.
Method lattice(const Medium& medium, double step);

/// Time of one look-up of a method, with its share of the loop, relative to psi-balanced between
/// uniform samples. `paired`: the luminance is stored beside the density. Measured on llvmpipe by
/// tools/bench/tolerance.py (docs/performance.md).
double look_up_cost(const MethodView& marched, bool paired);

}  // namespace psivox
