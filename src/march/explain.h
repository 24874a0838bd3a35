#pragma once

#include "march/medium_atlas.h"
#include "psivox/draw.h"

namespace psivox {

/// What the march of a view computes, what it leaves out because the picture does not depend on it,
/// and why. Light may still be pending.
std::vector<Explanation> explain(const View& view, const MediumAtlas& atlas);

/// Whether the view's march corrects the ends of its lattice: psi-balanced does, where rays may
/// begin inside the medium and nothing else in the scene forbids it.
bool has_end_corrections(const View& view);

}  // namespace psivox
