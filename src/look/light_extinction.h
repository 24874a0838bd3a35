#pragma once

#include "psivox/medium.h"

namespace psivox {

/// Extinction [1/world unit] at which a third of the first light's intensity reaches the medium of
/// a view, on average over what it attenuates; at least the view's own. In a sparse medium 0.6
/// reaches it, and the least is an eighth of the view's own. Attenuations are taken from voxels
/// along straight steps of a voxel, from some thousands of them.
double light_extinction(const View& view, bool sparse);

}  // namespace psivox
