#pragma once

#include "march/marcher.h"

namespace psivox {

/// Draws --mode slice: the density on a plane, interpolated in double precision on the CPU, with
/// the colours of the colour map or transfer function. It takes the place of every marcher.
RenderResult draw_slice(const View& view, const RenderOptions& options);

}  // namespace psivox
