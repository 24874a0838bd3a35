#pragma once

#include "psivox/camera.h"
#include "psivox/medium.h"

namespace psivox {

/// The blocks of the medium that are visible under the mode: leaves and tiles, shrunk to the voxels
/// whose attenuation or emission is at least a thousandth of the grid's greatest, and grown by the
/// voxel that the interpolation reaches. The greatest leaves out the highest thousandth of the
/// voxels, so that one odd value does not hide all others. Of more than 131,072 leaves, those in a
/// cube of 16, 32, ... voxels are one block. The whole domain if nothing is visible.
Subject subject_of(const Medium& medium, Mode mode);

}  // namespace psivox
