#pragma once

#include <string>

#include "scene/camera_file.h"

namespace psivox {

/// The camera of that name in a .gltf or .glb file, in glTF's own axes; the first if `name` is
/// empty. Throws Error(input) with `source`, the file's path, in its message.
FileCamera camera_from_gltf(const std::string& bytes, const std::string& name,
                            const std::string& source);

/// A glTF file with one camera, given in glTF's own axes. `aspect` is width over height.
std::string gltf_of(const FileCamera& camera, double aspect);

/// The animations of a .gltf or .glb file, all together, as they move the camera of that name, the
/// first if it is empty; in glTF's own axes. Buffers are looked for beside `source`. Throws
/// Error(input).
CameraAnimation animation_from_gltf(const std::string& bytes, const std::string& name,
                                    const std::string& source);

}  // namespace psivox
