#pragma once

#include "march/medium_atlas.h"
#include "psivox/draw.h"

namespace psivox {

/// What the march of a view computes, what it leaves out because the picture does not depend on it,
/// and why. Light may still be pending.
std::vector<Explanation> explain(const View& view, const MediumAtlas& atlas);

}  // namespace psivox
