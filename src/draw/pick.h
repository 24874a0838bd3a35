#pragma once

#include "march/medium_atlas.h"

namespace psivox {

/// Session::pick for a view and its atlas, marched in double by the view's method.
std::optional<glm::dvec3> pick_point(const View& view, const MediumAtlas& atlas,
                                     const glm::dvec2& pixel);

}  // namespace psivox
