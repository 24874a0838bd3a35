#pragma once

#include <string>

#include "psivox/atlas.h"

namespace psivox::bench {

/// Look-ups a second of a shader that does nothing else: 8 fetches each from the atlas's texels, a
/// cell's corners, neighbouring pixels in neighbouring cells. What a march cannot exceed. A
/// software renderer's seconds are of processor time.
double fetch_rate(const BrickAtlas& atlas);

/// Whether this renderer (GL_RENDERER) is Mesa's on the CPU, whose work is processor time.
bool is_software(const std::string& renderer);

}  // namespace psivox::bench
