#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scene/camera_file.h"

namespace psivox {

/// The camera of that name in a glTF file's JSON, in glTF's own axes; the first if `name` is empty.
/// Throws Error(input) with `source` in its message.
FileCamera camera_from_gltf(const std::string& text, const std::string& name,
                            const std::string& source);

/// The camera in parsed JSON. Throws nlohmann's exceptions where that is not valid.
FileCamera camera_from_gltf(const nlohmann::ordered_json& gltf, const std::string& name,
                            const std::string& source);

/// A glTF file with one camera, given in glTF's own axes. `aspect` is width over height.
std::string gltf_of(const FileCamera& camera, double aspect);

/// The JSON of a .glb file. Throws Error(input).
std::string json_of_glb(const std::string& bytes, const std::string& source);
/// The binary chunk that follows it; empty if there is none.
std::string buffer_of_glb(const std::string& bytes, const std::string& source);

/// The animations of a .gltf or .glb file, all together, as they move the camera of that name, the
/// first if it is empty; in glTF's own axes. `source` is the file's path: buffers are looked for
/// beside it. Throws Error(input).
CameraAnimation animation_from_gltf(const std::string& bytes, const std::string& name,
                                    const std::string& source);

}  // namespace psivox
