#pragma once

#include "psivox/scene.h"
#include "scene/environment.h"

namespace psivox {

/// Reads the scene's environment, whose up_axis is known. Throws Error(input) if the file is no
/// latitude-longitude map of finite radiance.
Environment read_environment(const Scene& scene);

}  // namespace psivox
