#include "scene/camera_file.h"

#include <array>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <utility>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr std::array<std::string_view, 3> extensions{".gltf", ".glb", ".pvcc"};

/// FILE and NAME of `FILE:NAME`; NAME is empty if the whole text is a file's name.
std::pair<std::string, std::string> split_name(const std::string& path) {
  if (is_camera_file(path)) return {path, ""};
  for (std::size_t colon = path.find(':'); colon != std::string::npos;
       colon = path.find(':', colon + 1))
    if (is_camera_file(path.substr(0, colon)))
      return {path.substr(0, colon), path.substr(colon + 1)};
  throw Error(ExitCode::usage, "--camera " + in_quotes(path) +
                                   ": expected FILE.gltf, FILE.glb or FILE.pvcc, and "
                                   ":NAME of a glTF camera");
}

/// Blender's axes from glTF's: Z is up, and glTF's -Z is Blender's +Y.
glm::dvec3 z_up_from_y_up(const glm::dvec3& v) { return {v.x, -v.z, v.y}; }
glm::dvec3 y_up_from_z_up(const glm::dvec3& v) { return {v.x, v.z, -v.y}; }

template <typename Map>
FileCamera mapped(FileCamera camera, Map map) {
  camera.position = map(camera.position);
  camera.target = map(camera.target);
  camera.up = map(camera.up);
  return camera;
}

void check(const FileCamera& camera, const std::string& source) {
  const bool flat = camera.projection == Projection::orthographic;
  if (flat ? !(camera.height > 0) : !(camera.vertical_fov > 0 && camera.vertical_fov < 180))
    throw Error(ExitCode::input, source + ": its camera has no field of view");
  if (!(glm::length(camera.target - camera.position) > 0) || !(glm::length(camera.up) > 0))
    throw Error(ExitCode::input, source + ": its camera has no direction");
}

FileCamera camera_to_keep(const Camera& camera) {
  FileCamera out;
  out.position = camera.position;
  out.target = camera.target;
  out.up = camera.up;
  out.projection = camera.orthographic ? Projection::orthographic : Projection::perspective;
  if (camera.orthographic)
    out.height = 2 * camera.half_height;
  else
    out.vertical_fov = glm::degrees(2 * std::atan(camera.half_height));
  return out;
}

}  // namespace

bool is_camera_file(std::string_view path) {
  for (const std::string_view extension : extensions)
    if (path.ends_with(extension)) return true;
  return false;
}

FileCamera read_camera(const std::string& path, bool z_up) {
  const auto [file, name] = split_name(path);
  const std::string text = read_text(file, "camera");
  FileCamera camera;
  if (file.ends_with(".pvcc")) {
    if (!name.empty())
      throw Error(ExitCode::usage, "--camera " + in_quotes(path) +
                                       ": a .pvcc has one camera; "
                                       "leave out the name");
    camera = camera_from_paraview(text, file);
  } else {
    camera = camera_from_gltf(text, name, file);
    if (z_up) camera = mapped(camera, z_up_from_y_up);
  }
  check(camera, file);
  return camera;
}

CameraAnimation read_camera_animation(const std::string& path, bool z_up) {
  const auto [file, name] = split_name(path);
  if (file.ends_with(".pvcc"))
    throw Error(ExitCode::usage,
                in_quotes(file) + " has no animation; give a .json, .gltf or .glb");
  CameraAnimation animation = animation_from_gltf(read_text(file, "camera"), name, file);
  animation.at = [z_up, file = file, in_gltf = animation.at](double seconds) {
    const FileCamera camera = z_up ? mapped(in_gltf(seconds), z_up_from_y_up) : in_gltf(seconds);
    check(camera, file);
    return camera;
  };
  animation.at(animation.begin);
  return animation;
}

void set_camera(Scene& scene, const FileCamera& camera) {
  const double aspect = double(scene.resolution.x) / scene.resolution.y;
  scene.camera_position = camera.position;
  scene.camera_target = camera.target;
  scene.camera_up = camera.up;
  scene.azimuth = scene.elevation = 0;
  scene.zoom = 1;
  scene.projection = camera.projection;
  scene.ortho_width.reset();
  if (camera.projection == Projection::orthographic)
    scene.ortho_width = camera.height * aspect;
  else
    scene.fov =
        glm::degrees(2 * std::atan(std::tan(glm::radians(camera.vertical_fov) / 2) * aspect));
}

void write_camera(const std::string& path, const Camera& camera, bool z_up) {
  const FileCamera kept = camera_to_keep(camera);
  if (path.ends_with(".pvcc")) return write_text(path, paraview_of(kept));
  if (!path.ends_with(".gltf"))
    throw Error(ExitCode::usage, in_quotes(path) + ": cameras are written as .gltf or .pvcc");
  write_text(path, gltf_of(z_up ? mapped(kept, y_up_from_z_up) : kept,
                           camera.half_width / camera.half_height));
}

}  // namespace psivox
