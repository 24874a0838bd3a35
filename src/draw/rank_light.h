#pragma once

#include "march/light.h"
#include "psivox/team.h"

namespace psivox {

/// Optical depths through a volume of which each of several processes holds a part. `own` gives
/// those of this one's part, towards any voxels. Each computes them for the voxels that the others
/// want and sends them, as float32; they add up, in an order that only the number of processes
/// decides. All must ask at once, each for its own voxels.
BeamDepths joined_depths(Team& team, LightDepths own);

}  // namespace psivox
