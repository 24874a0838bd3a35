#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// Colour at u, clamped to [0, 1]: linear Rec. 709 radiance, 1 is white. The maps are defined as
/// sRGB codes at knots; between knots the decoded radiance is linear.
glm::dvec3 colormap_color(Colormap map, double u);

/// Places of the map's knots, from 0 to 1.
std::vector<double> colormap_knots(Colormap map);

}  // namespace psivox
