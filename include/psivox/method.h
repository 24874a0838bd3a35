#pragma once

#include <string>

#include "psivox/scene.h"

namespace psivox {

/// How the march evaluates the integral along a ray: by which rule, between which points.
struct Method {
  Integrator integrator = Integrator::psi_weighted;
  Sampling sampling = Sampling::cells;
  int segments = 0;  ///< linear segments per cell, under cells; else 0
  double step = 0;   ///< [voxels of the finest axis], under uniform; else 0
  bool operator==(const Method&) const = default;
};

/// "uniform psi-balanced, step 1.7", "cells psi-weighted, segments 2", "cells cell-exact".
std::string method_text(const Method& method);

/// The scene with that method and without a tolerance, which would choose another.
Scene with_method(Scene scene, const Method& method);

}  // namespace psivox
