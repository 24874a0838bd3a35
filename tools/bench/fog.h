#pragma once

#include "psivox/field.h"

namespace psivox::bench {

/// Procedural fog: seven soft spheres times value noise, values in [0,1], n^3 lattice around the
/// origin with voxels of 2/n, about 20 % of it active (the scene that peers are measured on at
/// n = 256).
Field make_fog(int n);

}  // namespace psivox::bench
