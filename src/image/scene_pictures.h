#pragma once

#include "psivox/scene.h"
#include "scene/cuts.h"
#include "scene/environment.h"

// Pictures that a scene names.

namespace psivox {

/// Reads the scene's environment, whose up_axis is known. Throws Error(input) if the file is no
/// latitude-longitude map of finite radiance.
Environment read_environment(const Scene& scene);

/// Reads the scene's holdout: the named layer, else the one that is called Z or depth, or the only
/// one. Throws Error(input) if there is none, or if the file has another size than the picture.
Holdout read_holdout(const Scene& scene);

}  // namespace psivox
