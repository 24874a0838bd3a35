#pragma once

#include <string>

#include "psivox/camera_file.h"

namespace psivox {

/// The animations of a .gltf or .glb file, all together, as they move the camera of that name, the
/// first if it is empty; in glTF's own axes. `source` is the file's path: buffers are looked for
/// beside it. Throws Error(input).
CameraAnimation animation_from_gltf(const std::string& bytes, const std::string& name,
                                    const std::string& source);

}  // namespace psivox
