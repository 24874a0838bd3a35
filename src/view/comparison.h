#pragma once

#include "psivox/scene.h"

namespace psivox::view {

/// What a comparison starts with on its right side: twice the step.
Scene coarser(const Scene& scene);

/// The right side of a comparison: the method of `other` as far as it needs no other volume, the
/// rest of `scene`.
Scene with_method_of(const Scene& other, Scene scene);

}  // namespace psivox::view
