#pragma once

#include "psivox/scene.h"

namespace psivox::view {

/// The right side that a comparison starts with: twice the step.
Scene coarser(const Scene& scene);

/// The right side of a comparison: the method of `other`, except what would need another volume,
/// and the rest of `scene`.
Scene with_method_of(const Scene& other, Scene scene);

}  // namespace psivox::view
