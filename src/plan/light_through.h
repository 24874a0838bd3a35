#pragma once

#include <algorithm>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "march/medium_atlas.h"
#include "medium/backdrop.h"

namespace psivox {

/// Pixels whose rays meet what may be bright: of the voxels that emit most, at most one in each of
/// 64 parts of the picture, and 64 of each further volume.
std::vector<glm::ivec2> glowing_pixels(const View& view, const MediumAtlas& atlas);

/// What the ray of one of these shows.
struct SeenPixel {
  glm::ivec2 pixel{0};
  glm::vec4 picture{0};  ///< R G B A

  double radiance() const { return double(std::max({picture.x, picture.y, picture.z})); }
};

/// By slot of the density's bricks: the greatest radiance that comes to the camera through each, at
/// least 1. A brick that misses an optical depth d is off by at most d times that. Of luminance,
/// further volumes and the backdrop it is a bound, whatever attenuates them. Emission counts by the
/// pixels that were seen, each for its part of the picture: a bound without what attenuates it is
/// 25 times what a flame shows.
std::vector<double> light_through(const View& view, const MediumAtlas& atlas,
                                  const Backdrop& behind, std::span<const SeenPixel> seen = {});

}  // namespace psivox
