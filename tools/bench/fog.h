#pragma once

#include "psivox/field.h"

namespace psivox::bench {

/// Procedural fog: seven soft spheres times value noise, with values in [0,1]. n^3 voxels of width
/// 2/n around the origin, about 20 % of them active. At n = 256 it is the scene that peers are
/// measured on.
Field make_fog(int n);

}  // namespace psivox::bench
