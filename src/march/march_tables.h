#pragma once

#include "march/march_parameters.h"

namespace psivox {

struct Ramps;

// Each appends a table to those of the setup and sets the parameters and constants that tell the
// march of it.

/// Knots and bins of a transfer function.
void place_transfer(const TransferFunction& function, MarchSetup& setup);

/// Its attenuation as ramps.
void place_ramps(const Ramps& ramps, MarchSetup& setup);

/// The gradient's part of a transfer function.
void place_gradient(const TransferFunction& function, MarchSetup& setup);

/// The table of `preintegrated` for the view's transfer function, once its sampling is set.
/// `may_update`: see Wish.
void place_preintegration(const View& view, bool may_update, MarchSetup& setup);

/// The table of `psi_table`.
void place_psi_table(MarchSetup& setup);

/// The ray template of the view's camera, over the density's voxels. Throws Error(usage) where
/// another grid has other voxels.
void place_template(const View& view, MarchSetup& setup);

/// The lights of a view in mode isosurface.
void place_surface_lights(const View& view, MarchSetup& setup);

/// Optical depths that rays of some pixels have passed before their region.
void place_passed(const std::vector<float>& depths, const PixelBox& pixels, MarchSetup& setup);

/// The planes of the scene's clip; the anchor plane is that far from the camera [world units].
void place_clip(const View& view, double anchor_distance, MarchSetup& setup);

/// Of each brick of the density the part of the step that is taken in it.
void place_brick_steps(const std::vector<float>& parts, const BrickAtlas& density,
                       MarchSetup& setup);

}  // namespace psivox
