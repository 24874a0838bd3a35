#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/field.h"

namespace psivox {

struct SampledVoxel {
  glm::ivec3 voxel;
  float value;  ///< first channel; not 0
};

/// About `wanted` of the voxels in the box of active ones whose values are not 0, spread evenly, in
/// a fixed order. The same values give the same sample, whether tiles or leaves hold them and
/// wherever leaves begin.
std::vector<SampledVoxel> sample_voxels(const Field& field, std::size_t wanted);

}  // namespace psivox
