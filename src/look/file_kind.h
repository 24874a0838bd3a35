#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "psivox/field.h"

namespace psivox {

/// Whether the values look like those of a scan or a simulation: whole steps of their greatest one,
/// at most 255 of them. In a grid that is not known to be a fog, integers and values that do not
/// fade to 0 tell so too.
bool is_scan(const Field& density, bool known_fog);

/// Whether most values are low, like those of vessels or plumes in their surroundings: their mean
/// is in the lowest quarter of the range.
bool is_mostly_low(const Field& density);

/// Whether values of both signs matter: the lower ones reach a twentieth of the greatest magnitude.
bool is_signed(const Field& density);

struct SampledVoxel {
  glm::ivec3 voxel;
  float value;  ///< first channel; not 0
};

/// About `wanted` of the voxels in the box of active ones whose values are not 0, spread evenly, in
/// a fixed order. The same values give the same sample, whether tiles or leaves hold them and
/// wherever leaves begin.
std::vector<SampledVoxel> sample_voxels(const Field& field, std::size_t wanted);

}  // namespace psivox
