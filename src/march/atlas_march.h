#pragma once

#include <bit>

#include "atlas/brick_code.h"
#include "march/glsl_subset.h"
#include "march/march_parameters.h"

namespace psivox::glsl {

/// The march in double over brick atlases.
struct AtlasMarch {
#include "march/atlas_members.h"
};

/// AtlasMarch::march, in one function: a fifth faster than what the compiler inlines by itself.
void march_on(AtlasMarch& march, AtlasMarch::March& state, const AtlasMarch::Ray& ray);

}  // namespace psivox::glsl
