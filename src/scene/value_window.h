#pragma once

#include "psivox/scene.h"
#include "scene/transfer_function.h"

namespace psivox {

/// The function of a scene that windows its values: u is 0 and 1 at the ends of `range`.
///
/// | | attenuation | colour |
/// |---|---|---|
/// | --opacity | the curve of u | |
/// | a colour map | the value, at least 0 | the map of u |
/// | maxima | u, at least 0 | the same: a value beyond the range is brighter than 1 |
/// | else | u within 0 and 1 | |
///
/// The first row that applies gives each. `stored` is the range of the grid's values, with 0.
TransferFunction window_function(const Scene& scene, const glm::dvec2& range,
                                 const glm::dvec2& stored);

}  // namespace psivox
