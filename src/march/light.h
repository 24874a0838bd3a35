#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "psivox/medium.h"
#include "psivox/progress.h"

namespace psivox {

/// Optical depths of the medium from the voxels of some blocks of 8^3 of its density to where the
/// light comes in: 512 a block, z fastest. Exact for trilinear data, whatever the view's rule;
/// where the transfer function has a gradient, of the view's segments but with the reference.
using LightDepths = std::function<std::vector<double>(std::span<const glm::ivec3> origins)>;

/// The view with its light scattered once: T_light = e^-depth is computed at every voxel of the
/// blocks that hold a corner of a cell with attenuation, and becomes the luminance's grid there,
///   L = luminance + radiance * T_light, or colour * (luminance + radiance * T_light)
/// where a transfer function gives colours. A luminance of another grid is interpolated at the
/// density's voxels. A view without light returns as it is.
View lit(View view, const LightDepths& depths, const Progress& progress = {});

/// The view whose march gives those depths: orthographic, looking towards the light, cells only.
View light_march(const View& view);

}  // namespace psivox
