#include "psivox/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "base/text.h"
#include "field/index_space.h"
#include "psivox/error.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

struct Frame {
  glm::dvec3 right, up, forward;

  glm::dmat3 axes() const { return {right, up, forward}; }
};

/// Throws if the view is along an `up` that was chosen. If it was not, an axis across the view
/// replaces it: the one that keeps +X on the right when looking up or down.
Frame make_frame(const glm::dvec3& forward, const glm::dvec3& up, bool chosen) {
  const glm::dvec3 unit_up = glm::normalize(up);
  glm::dvec3 right = glm::cross(forward, unit_up);
  // |F x up| is the sine of their angle; R's relative error is about 1e-16 over it. At 1e-6 the
  // picture still turns by less than 1e-10, far below a pixel.
  if (glm::length(right) < 1e-6) {
    if (chosen)
      throw Error(ExitCode::usage,
                  "--camera-up is parallel to the view; change it or --camera-position");
    const double side = glm::dot(forward, unit_up) < 0 ? 1 : -1;
    right = glm::cross(forward, unit_up.z > 0.5 ? glm::dvec3(0, side, 0) : glm::dvec3(0, 0, -side));
  }
  right = glm::normalize(right);
  return {right, glm::cross(right, forward), forward};
}

/// The view from the front: along -Z, or along +Y if Z is up.
glm::dvec3 front(const glm::dvec3& up) {
  const double z = up.z / glm::length(up);
  if (std::abs(z) > 0.9) return {0, z > 0 ? 1 : -1, 0};
  return {0, 0, -1};
}

/// The default view: from the front, or across the slice.
glm::dvec3 facing(const Scene& scene, const glm::dvec3& from_front) {
  if (!scene.shows(Shows::plane) || !scene.slice) return from_front;
  const glm::dvec3 normal = glm::normalize(scene.slice->normal);
  // The side that is nearer to the front; of a plane that is seen edge-on, that of its normal.
  return glm::dot(normal, from_front) > 1e-9 ? normal : -normal;
}

/// What of the subject the default camera frames. A slice shows the whole domain, and so does a
/// box, with room for its numbers.
Subject framed_subject(const Scene& scene, const Subject& whole) {
  Subject subject = whole;
  if (scene.shows(Shows::plane) || scene.box) {
    constexpr double beside_box = 0.08;  // of the box's size, on each side
    const glm::dvec3 room = (scene.box ? beside_box : 0) * (whole.box_max - whole.box_min);
    subject = box_subject(whole.box_min - room, whole.box_max + room);
    subject.z_up = whole.z_up;
  }
  const std::vector<HalfSpace> clip = clip_of(scene);
  return clip.empty() ? subject : clipped(subject, clip);
}

/// The camera moves to the right by the azimuth, about `up`, and then upwards by the elevation.
Frame turned(const Frame& frame, const glm::dvec3& up, double azimuth, double elevation) {
  const glm::dmat3 aside(glm::rotate(glm::dmat4(1), glm::radians(azimuth), glm::normalize(up)));
  const glm::dvec3 right = aside * frame.right;
  const glm::dmat3 rise(glm::rotate(glm::dmat4(1), -glm::radians(elevation), right));
  return {right, rise * aside * frame.up, rise * aside * frame.forward};
}

/// The frame of the scene's camera, and the `up` that gives it again.
struct Direction {
  Frame frame;
  glm::dvec3 up;
};

Direction direction_of(const Scene& scene, const glm::dvec3& forward, const glm::dvec3& up) {
  const Frame frame = make_frame(forward, up, scene.camera_up.has_value());
  if (scene.azimuth == 0 && scene.elevation == 0) return {frame, up};
  const Frame moved = turned(frame, up, scene.azimuth, scene.elevation);
  // At the pole and beyond it, the axis does not tell which way is up.
  const bool upright = glm::dot(moved.up, glm::normalize(up)) > 1e-3;
  return {moved, upright ? up : moved.up};
}

/// Distance from the camera to its target. `given`: the scene has the position, else the volume.
double view_length(const Camera& camera, bool given) {
  const double length = glm::length(camera.target - camera.position);
  if (!given && !(length > 0 && std::isfinite(length)))
    throw Error(ExitCode::input,
                "the volume is too large, or too far from the origin, for a camera to see it");
  if (!(length > 0))
    throw Error(ExitCode::usage,
                "the camera's position equals its target; set --camera-position or "
                "--camera-target");
  if (!std::isfinite(length))
    throw Error(ExitCode::usage, "--camera-position is too far from --camera-target");
  return length;
}

/// Mirrors i's binary digits at the point: van der Corput's sequence, in [0, 1).
double radical_inverse(unsigned i) {
  double value = 0;
  for (double digit = 0.5; i; i >>= 1, digit /= 2) value += (i & 1) * digit;
  return value;
}

void check_camera(const Scene& scene) {
  const double fov = horizontal_fov(scene);
  // beyond these float32 loses rays, or double the distance at which the volume is in frame
  constexpr double narrowest = 1e-100, widest = 179.9999;
  if (!(fov >= narrowest && fov <= widest))
    throw Error(ExitCode::usage, "the field of view is " + number_text(fov) +
                                     " degrees, but goes from " + number_text(narrowest) + " to " +
                                     number_text(widest) + "; change --fov or --zoom");
  if (scene.resolution.x < 1 || scene.resolution.y < 1)
    throw Error(ExitCode::usage, "--resolution must be at least 1x1");
  if (scene.camera_up && !has_direction(*scene.camera_up))
    throw Error(ExitCode::usage, "--camera-up has no direction: it is 0");
}

}  // namespace

int color_bar_strip(const glm::ivec2& resolution) {
  const double text = std::clamp(resolution.y / 28.0, 11.0, 60.0);  // height of the letters
  const int strip = int(std::lround(7 * text));
  return 2 * strip <= resolution.x && 7 * text <= resolution.y ? strip : 0;
}

glm::dvec3 from_camera(const Camera& camera, const glm::dvec3& vector) {
  return vector.x * camera.right + vector.y * camera.up - vector.z * camera.forward;
}

double horizontal_fov(const Scene& scene) {
  const double tangent = scene.fov ? std::tan(glm::radians(*scene.fov) / 2)
                                   : scene.aperture / (2 * scene.focal_length);
  if (scene.fov && scene.zoom == 1) return *scene.fov;
  return glm::degrees(2 * std::atan(tangent / scene.zoom));
}

bool z_is_up(const Scene& scene, const Subject& subject) {
  return scene.up_axis == UpAxis::automatic ? !subject.z_up.empty() : scene.up_axis == UpAxis::z;
}

glm::dvec3 up_direction(const Scene& scene, const Subject& subject) {
  if (scene.camera_up) return *scene.camera_up;
  return z_is_up(scene, subject) ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
}

Camera make_camera(const Scene& scene, const glm::dvec3& box_min, const glm::dvec3& box_max) {
  return make_camera(scene, box_subject(box_min, box_max));
}

Camera make_camera(const Scene& scene, const Subject& whole) {
  check_camera(scene);
  const Subject subject = framed_subject(scene, whole);
  const double fov = horizontal_fov(scene);
  const double aspect = double(scene.resolution.x) / scene.resolution.y;
  Camera camera;
  camera.orthographic = scene.projection == Projection::orthographic;
  camera.half_width = std::tan(glm::radians(fov) / 2);
  // The zoom makes the picture larger, so it does not take part in the framing.
  const double framed_width = camera.half_width * scene.zoom;
  const double strip =
      scene.color_bar ? color_bar_strip(scene.resolution) / double(scene.resolution.x) : 0;
  const glm::dvec3 up = up_direction(scene, subject);
  Direction direction;
  if (scene.camera_position) {
    camera.target = scene.camera_target ? *scene.camera_target : middle_of(subject);
    camera.position = *scene.camera_position;
    const double length = view_length(camera, true);
    direction = direction_of(scene, (camera.target - camera.position) / length, up);
    if (scene.azimuth != 0 || scene.elevation != 0)
      camera.position = camera.target - length * direction.frame.forward;
  } else {
    direction = direction_of(scene, facing(scene, front(up)), up);
    const Framing framing =
        framing_of(subject, direction.frame.axes(), framed_width, framed_width / aspect,
                   camera.orthographic, scene.camera_target, strip);
    camera.target = framing.target;
    camera.position = framing.target - framing.distance * direction.frame.forward;
  }

  // The frame always comes from the two points, even if they came from a frame. So a scene printed
  // with its resolved points gives the same camera to the last bit.
  camera.camera_up = direction.up;
  const double length = view_length(camera, scene.camera_position.has_value());
  const Frame frame = make_frame((camera.target - camera.position) / length, camera.camera_up,
                                 scene.camera_up.has_value());
  camera.right = frame.right;
  camera.up = frame.up;
  camera.forward = frame.forward;
  const bool along_up = std::abs(glm::dot(frame.up, camera.camera_up)) < 1e-6;
  if (along_up) camera.camera_up = frame.up;

  if (camera.orthographic) {
    const double width = scene.ortho_width
                             ? *scene.ortho_width
                             : 2 * framing_of(subject, frame.axes(), framed_width,
                                              framed_width / aspect, true, camera.position, strip)
                                       .half_width;
    camera.half_width = width / 2 / scene.zoom;
    if (!(camera.half_width > 0)) throw Error(ExitCode::usage, "--ortho-width must be above 0");
  }
  camera.half_height = camera.half_width / aspect;
  return camera;
}

void keep_camera(Scene& scene, const Camera& camera) {
  scene.camera_position = camera.position;
  scene.camera_target = camera.target;
  scene.camera_up = camera.camera_up;
  scene.azimuth = scene.elevation = 0;
  scene.fov = horizontal_fov(scene);
  scene.zoom = 1;
  if (camera.orthographic) scene.ortho_width = 2 * camera.half_width;
}

CameraMatrices camera_matrices(const Camera& camera) {
  const glm::dmat3 turn = glm::transpose(glm::dmat3(camera.right, camera.up, camera.forward));
  glm::dmat4 to_camera(turn);
  to_camera[3] = glm::dvec4(-(turn * camera.position), 1);
  const double x = 0.5 / camera.half_width, y = -0.5 / camera.half_height;
  glm::dmat4 image(1);  // the depth is as it is, which nobody reads
  image[0].x = x;
  image[1].y = y;
  image[camera.orthographic ? 3 : 2] += glm::dvec4(0.5, 0.5, 0, 0);
  if (!camera.orthographic) {
    image[2].w = 1;
    image[3] = glm::dvec4(0, 0, -1, 0);
  }
  return {to_camera, image * to_camera};
}

double VisibleGrid::reach(const VisibleBlock& block, const glm::dvec3& direction) const {
  const glm::dvec3 per_voxel = glm::transpose(glm::dmat3(world_from_index)) * direction;
  return glm::dot(direction, glm::dvec3(world_from_index[3])) +
         glm::dot(per_voxel, 0.5 * (block.min + block.max)) +
         glm::dot(glm::abs(per_voxel), 0.5 * (block.max - block.min));
}

void world_bounds(const Field& field, glm::dvec3& box_min, glm::dvec3& box_max) {
  std::tie(box_min, box_max) = bounds_of(field.domain(), field.world_from_index);
}

glm::dvec2 pixel_sample(int i, int n) {
  // Uses the place of the radical inverse among the n, not the inverse itself. Then, for any n,
  // both coordinates have one sample in each n-th of the pixel, and the mean 1/2.
  const double own = radical_inverse(unsigned(i));
  int place = 0;
  for (int j = 0; j < n; ++j) place += radical_inverse(unsigned(j)) < own;
  return {(i + 0.5) / n, (place + 0.5) / n};
}

WorldRay camera_ray(const Camera& camera, const glm::ivec2& resolution, double x, double y) {
  const glm::dvec3 shift = camera.right * ((2 * x / resolution.x - 1) * camera.half_width) +
                           camera.up * ((1 - 2 * y / resolution.y) * camera.half_height);
  if (camera.orthographic) return {camera.position + shift, camera.forward};
  return {camera.position, glm::normalize(camera.forward + shift)};
}

RayBundle make_ray_bundle(const Camera& camera, const Field& field, const Field& centre) {
  RayBundle bundle;
  bundle.orthographic = camera.orthographic;

  const Box seen = centre.domain();
  const glm::dvec3 middle(centre.world_from_index *
                          glm::dvec4(0.5 * (glm::dvec3(seen.min) + glm::dvec3(seen.max)), 1));
  bundle.distance = std::max(0.0, glm::dot(middle - camera.position, camera.forward));

  const Box domain = field.domain();
  const glm::dvec3 half_sum = 0.5 * (glm::dvec3(domain.min) + glm::dvec3(domain.max));
  bundle.origin = 8 * glm::ivec3(glm::round(half_sum / 8.0));

  const glm::dvec3 shift_u = camera.right * camera.half_width;
  const glm::dvec3 shift_v = camera.up * camera.half_height;
  // A perspective ray is at position + distance * w(u, v) on the anchor plane, because w . F = 1.
  const double spread = camera.orthographic ? 1 : bundle.distance;
  const double turn = camera.orthographic ? 0 : 1;
  bundle.world_0 = camera.forward;
  bundle.world_u = turn * shift_u;
  bundle.world_v = turn * shift_v;

  const glm::dmat3 linear = glm::inverse(glm::dmat3(field.world_from_index));
  const glm::dvec3 origin_world(field.world_from_index * glm::dvec4(bundle.origin, 1));
  const glm::dvec3 anchor = camera.position + bundle.distance * camera.forward;
  bundle.anchor_0 = linear * (anchor - origin_world);
  bundle.anchor_u = linear * (spread * shift_u);
  bundle.anchor_v = linear * (spread * shift_v);
  bundle.direction_0 = linear * bundle.world_0;
  bundle.direction_u = linear * bundle.world_u;
  bundle.direction_v = linear * bundle.world_v;
  return bundle;
}

}  // namespace psivox
