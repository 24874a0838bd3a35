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

}  // namespace psivox
