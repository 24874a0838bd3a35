#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "march/march_parameters.h"
#include "scene/transfer_function.h"

namespace psivox {

struct Ramps;

/// Appends entries to the setup's tables; returns where the first one is.
int append(const std::vector<glm::vec4>& entries, MarchSetup& setup);

// Each appends a table to those of the setup and sets the parameters and constants that tell the
// march of it.

/// Knots and bins of a transfer function.
void place_transfer(const TransferFunction& function, MarchSetup& setup);

/// The attenuation of a transfer function as ramps.
void place_ramps(const Ramps& ramps, MarchSetup& setup);

/// The gradient's part of a transfer function.
void place_gradient(const TransferFunction& function, MarchSetup& setup);

/// The table of `preintegrated` for the view's transfer function. `may_update`: see Wish.
std::shared_ptr<const PreintegratedTable> preintegration_of(const View& view, bool may_update);
void place_preintegration(const View& view, bool may_update, MarchSetup& setup);

/// The table of `psi_table`.
void place_psi_table(MarchSetup& setup);

/// The ray template of the view's camera, over the density's voxels. Throws Error(usage) where
/// another grid has other voxels.
void place_template(const View& view, MarchSetup& setup);

/// The surfaces of a view in mode isosurface, and their lights.
void place_surfaces(const View& view, MarchSetup& setup);

/// What rays of some pixels have passed before their region (RenderOptions::passed).
void place_passed(const std::vector<float>& passed, const PixelBox& pixels, MarchSetup& setup);

/// The planes of the scene's clip; the anchor plane is that far from the camera [world units].
void place_clip(const View& view, double anchor_distance, MarchSetup& setup);

/// The depths at which the view's rays are held out, from the anchor plane that far from the
/// camera.
void place_holdout(const View& view, double anchor_distance, MarchSetup& setup);

/// The part of the step that each brick of the density takes.
void place_brick_steps(const std::vector<float>& parts, const BrickAtlas& density,
                       MarchSetup& setup);

/// The further volumes of the atlas.
void place_others(const View& view, const MediumAtlas& atlas, MarchSetup& setup);

/// The table that shaders/integrators/psi_table.glsl reads: an entry for each cell, the front end's
/// place major, with the values at (front, back) = (i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1).
std::vector<glm::vec4> make_psi_table();

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
