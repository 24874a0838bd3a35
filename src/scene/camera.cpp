#include "psivox/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "psivox/error.h"

namespace psivox {
namespace {

constexpr double frame_margin = 0.05;  // of the half width and half height, left free

struct Frame {
  glm::dvec3 right, up, forward;
};

std::array<glm::dvec3, 8> corners(const glm::dvec3& min, const glm::dvec3& max) {
  std::array<glm::dvec3, 8> out;
  for (unsigned i = 0; i < 8; ++i)
    out[i] = {i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z};
  return out;
}

/// Throws if the view is along a chosen `up`. If `up` is the default, an axis across the view
/// replaces it: the one that keeps +X on the right when looking up or down.
Frame make_frame(const glm::dvec3& forward, const glm::dvec3& up) {
  const glm::dvec3 unit_up = glm::normalize(up);
  glm::dvec3 right = glm::cross(forward, unit_up);
  // |F x up| is the sine of their angle; R's relative error is about 1e-16 over it. At 1e-6 the
  // picture still turns by less than 1e-10, far below a pixel.
  if (glm::length(right) < 1e-6) {
    if (up != Scene{}.camera_up)
      throw Error(ExitCode::usage,
                  "--camera-up is parallel to the view; change it or --camera-position");
    right = glm::cross(forward, glm::dvec3(0, 0, forward.y < 0 ? -1 : 1));
  }
  right = glm::normalize(right);
  return {right, glm::cross(right, forward), forward};
}

/// Distance from `aim`, backwards along the view, from which all corners project inside the frame.
double framing_distance(const std::array<glm::dvec3, 8>& box, const glm::dvec3& aim,
                        const Frame& frame, double half_width, double half_height) {
  double distance = 0;
  for (const glm::dvec3& corner : box) {
    const glm::dvec3 q = corner - aim;
    // |x| <= (1 - margin) * half_width * (distance + depth), and the same for y
    const double wide = std::abs(glm::dot(q, frame.right)) / half_width;
    const double high = std::abs(glm::dot(q, frame.up)) / half_height;
    distance =
        std::max(distance, std::max(wide, high) / (1 - frame_margin) - glm::dot(q, frame.forward));
  }
  return distance;
}

/// Half width of an orthographic picture, centred on `aim`, that holds all corners.
double framing_half_width(const std::array<glm::dvec3, 8>& box, const glm::dvec3& aim,
                          const Frame& frame, double aspect) {
  double half = 0;
  for (const glm::dvec3& corner : box) {
    const glm::dvec3 q = corner - aim;
    half = std::max(
        {half, std::abs(glm::dot(q, frame.right)), std::abs(glm::dot(q, frame.up)) * aspect});
  }
  return half / (1 - frame_margin);
}

/// Mirrors i's binary digits at the point: van der Corput's sequence, in [0, 1).
double radical_inverse(unsigned i) {
  double value = 0;
  for (double digit = 0.5; i; i >>= 1, digit /= 2) value += (i & 1) * digit;
  return value;
}

}  // namespace

double horizontal_fov(const Scene& scene) {
  if (scene.fov) return *scene.fov;
  return glm::degrees(2 * std::atan(scene.aperture / (2 * scene.focal_length)));
}

Camera make_camera(const Scene& scene, const glm::dvec3& box_min, const glm::dvec3& box_max) {
  const double fov = horizontal_fov(scene);
  if (!(fov > 0 && fov < 180))
    throw Error(ExitCode::usage, "--fov must be above 0 and below 180 degrees");
  if (scene.resolution.x < 1 || scene.resolution.y < 1)
    throw Error(ExitCode::usage, "--resolution must be at least 1x1");
  if (scene.camera_up == glm::dvec3(0))
    throw Error(ExitCode::usage, "--camera-up 0,0,0 has no direction");

  const double aspect = static_cast<double>(scene.resolution.x) / scene.resolution.y;
  const double half_width = std::tan(glm::radians(fov) / 2);
  const auto box = corners(box_min, box_max);

  Camera camera;
  camera.target = scene.camera_target.value_or(0.5 * (box_min + box_max));
  if (scene.camera_position) {
    camera.position = *scene.camera_position;
  } else {
    const Frame frame = make_frame({0, 0, -1}, scene.camera_up);
    const double distance =
        framing_distance(box, camera.target, frame, half_width, half_width / aspect);
    camera.position = camera.target - distance * frame.forward;
  }

  // The frame always comes from the two points, even if they came from a frame. So a scene printed
  // with its resolved points gives the same camera to the last bit.
  const glm::dvec3 view = camera.target - camera.position;
  const double length = glm::length(view);
  if (!(length > 0))
    throw Error(ExitCode::usage,
                "the camera's position equals its target; set --camera-position or "
                "--camera-target");
  if (!std::isfinite(length))
    throw Error(ExitCode::usage, "--camera-position is too far from --camera-target");
  const Frame frame = make_frame(view / length, scene.camera_up);
  camera.right = frame.right;
  camera.up = frame.up;
  camera.forward = frame.forward;

  camera.orthographic = scene.projection == Projection::orthographic;
  camera.half_width = half_width;
  if (camera.orthographic) {
    camera.half_width = scene.ortho_width ? *scene.ortho_width / 2
                                          : framing_half_width(box, camera.position, frame, aspect);
    if (!(camera.half_width > 0)) throw Error(ExitCode::usage, "--ortho-width must be above 0");
  }
  camera.half_height = camera.half_width / aspect;
  return camera;
}

void world_bounds(const Field& field, glm::dvec3& box_min, glm::dvec3& box_max) {
  const Box domain = field.domain();
  box_min = glm::dvec3(INFINITY);
  box_max = glm::dvec3(-INFINITY);
  for (const glm::dvec3& corner : corners(domain.min, domain.max)) {
    const glm::dvec3 p(field.world_from_index * glm::dvec4(corner, 1));
    box_min = glm::min(box_min, p);
    box_max = glm::max(box_max, p);
  }
}

glm::dvec2 pixel_sample(int i, int n) {
  // Uses the rank of the radical inverse among the n, not the inverse itself. Then, for any n, both
  // coordinates have one sample in each n-th of the pixel, and the mean 1/2.
  const double own = radical_inverse(static_cast<unsigned>(i));
  int rank = 0;
  for (int j = 0; j < n; ++j) rank += radical_inverse(static_cast<unsigned>(j)) < own;
  return {(i + 0.5) / n, (rank + 0.5) / n};
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
