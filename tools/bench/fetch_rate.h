#pragma once

#include <string>

#include "psivox/atlas.h"

namespace psivox::bench {

/// Look-ups per second of a shader that does nothing else. A look-up is 8 fetches of a cell's
/// corners from the atlas's texels; neighbouring pixels read neighbouring cells. No march can be
/// faster. For a software renderer the seconds are CPU time.
double fetch_rate(const BrickAtlas& atlas);

/// Whether this renderer (GL_RENDERER) is Mesa's on the CPU, whose work is measured in CPU time.
bool is_software(const std::string& renderer);

}  // namespace psivox::bench
