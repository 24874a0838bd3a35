#pragma once

#include "march/light_lattice.h"

namespace psivox {

/// Optical depths along the columns of a light's lattice through the atlas of a view, by all
/// threads: columns run along the light and are recorded where they cross the slices of voxels, so
/// that a voxel's depth is interpolated across columns only (after the slices of Lacroute and Levoy
/// 1994). From slice to slice they follow Simpson's rule; where there is a transfer function of the
/// value alone, its integrals over both halves of the step, as if the values were linear there.
/// Reals are float or double; places are double. Frame, view and atlas must outlive what it
/// returns.
template <typename Real>
LatticeColumns light_columns(const LatticeFrame& frame, const View& view, const MediumAtlas& atlas,
                             const Beam& beam);

}  // namespace psivox
