#pragma once

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "march/light.h"
#include "march/medium_atlas.h"

// Shared by the tests of light.

namespace psivox {

/// Optical depths at the voxels of `blocks`, 512 a block: towards the view's first light, or the
/// sky's first direction, by a method.
inline std::vector<double> depths_of(const View& view, const LightDepths& depths,
                                     std::span<const glm::ivec3> blocks,
                                     const LightMethod& method = {}) {
  const std::vector<glm::ivec3> visible =
      visible_blocks(*view.medium.density, density_options(view));
  std::vector<glm::ivec3> all(visible);
  for (const glm::ivec3& block : blocks)
    if (std::find(all.begin(), all.end(), block) == all.end()) all.push_back(block);
  std::vector<std::size_t> wanted;
  for (const glm::ivec3& block : blocks)
    wanted.push_back(std::size_t(std::find(all.begin(), all.end(), block) - all.begin()));
  Beam beam = light_beams(view).front();
  beam.method = method;
  std::vector<double> result(512 * blocks.size());
  depths(beam, {all, wanted},
         [&](std::size_t block, std::span<const double> part) {
           const auto at = std::find(wanted.begin(), wanted.end(), block) - wanted.begin();
           std::copy(part.begin(), part.end(), result.begin() + 512 * at);
         },
         {});
  return result;
}

}  // namespace psivox
