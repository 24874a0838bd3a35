#pragma once

#include <string>

#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// Sets a scene's emission to black bodies over a flame's grid. Values above 200 are Kelvin; others
/// become 1000 K at 0 to 2500 K at the greatest. The emission's scale puts the brightest hundredth
/// of the flame's pixels just below white.
void set_flame(Scene& scene, const VdbFile& file, const std::string& grid);

}  // namespace psivox
