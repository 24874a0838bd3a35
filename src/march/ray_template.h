#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

namespace psivox {

/// The voxels that a ray from a voxel's centre takes (R. Yagel, Efficient Methods for Volumetric
/// Graphics, 1991): entry k is (offset from the first voxel, t), t the multiple of `direction`
/// nearest the offset.
struct RayTemplate {
  int axis = 0;        ///< of the largest component: the base plane is perpendicular to it
  double spacing = 0;  ///< mean difference of t between entries
  std::vector<glm::vec4> entries;
};

/// Neighbours share at least a corner (connectivity 26: one voxel for each plane along `axis`), an
/// edge (18) or a face (6: every voxel that the line pierces). `planes` of voxels along the axis
/// are crossed. Throws Error(usage) for more than 2^22 entries.
RayTemplate make_ray_template(const glm::dvec3& direction, int planes, int connectivity);

}  // namespace psivox
