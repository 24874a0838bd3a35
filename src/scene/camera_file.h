#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>

#include "psivox/camera.h"
#include "psivox/scene.h"

namespace psivox {

/// A camera as other programs keep it: the height of the picture counts, its width follows from the
/// resolution.
struct FileCamera {
  glm::dvec3 position{0}, target{0, 0, -1}, up{0, 1, 0};  ///< [world]
  Projection projection = Projection::perspective;
  double vertical_fov = 45;  ///< [degrees]
  double height = 1;         ///< of an orthographic picture [world units]
};

/// Whether the name ends in .gltf, .glb or .pvcc.
bool is_camera_file(std::string_view path);

/// Reads `FILE` or `FILE:NAME`: a camera of a glTF file (.gltf, .glb), by its own name or its
/// node's, else the file's first; or ParaView's camera (.pvcc). glTF's Y is up; with `z_up` the
/// volume's Z is, and psivox turns the camera as Blender does when it writes glTF. Throws
/// Error(input).
FileCamera read_camera(const std::string& path, bool z_up);

/// A camera that an animation moves.
struct CameraAnimation {
  double begin = 0, end = 0;                     ///< of its keys [s]
  std::function<FileCamera(double seconds)> at;  ///< before and after its keys, with theirs
};

/// The animation of a glTF file (.gltf, .glb), for a camera chosen as by read_camera. Throws
/// Error(input), also where nothing is animated.
CameraAnimation read_camera_animation(const std::string& path, bool z_up);

/// Gives the camera to the scene, for the scene's resolution.
void set_camera(Scene& scene, const FileCamera& camera);

/// Writes .gltf or .pvcc, by the extension; `z_up` as in read_camera. Throws Error(usage) for
/// another extension, Error(output).
void write_camera(const std::string& path, const Camera& camera, bool z_up);

// By its formats: gltf.cpp and paraview_camera.cpp.

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

/// ParaView's camera (.pvcc). Throws Error(input) with `source` in its message.
FileCamera camera_from_paraview(const std::string& text, const std::string& source);

std::string paraview_of(const FileCamera& camera);

}  // namespace psivox
