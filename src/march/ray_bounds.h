#pragma once

#include "march/march_parameters.h"

namespace psivox {

/// More turns than any ray of the march can take. `finest_step`: under uniform [unit of t].
double turn_bound(const MarchSetup& setup, double finest_step);

/// Bound on the optical depth of a ray through the density.
double depth_bound(const Medium& medium, const BrickAtlas& density);

}  // namespace psivox
