#pragma once

#include "scene/holdout.h"

namespace psivox {

/// Reads the scene's holdout: the named layer, else the one that is called Z or depth, or the only
/// one. Throws Error(input) if there is none, or if the file has another size than the picture.
Holdout read_holdout(const Scene& scene);

}  // namespace psivox
