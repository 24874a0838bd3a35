#pragma once

#include <glm/vec3.hpp>

namespace psivox {

/// Linear Rec. 709 radiance of a black body, such that 6500 K has luminance (CIE Y) 1. Channels
/// that would be negative, outside the gamut of Rec. 709, are 0: blue below about 1900 K, green too
/// below about 1000 K. The result is 0 up to 200 K, where the radiance is below float32's least
/// normal number. Relative error of X, Y and Z against the integral: 1e-5. May be called from
/// several threads.
glm::dvec3 black_body(double kelvin);

}  // namespace psivox
