#include "view/navigation.h"

#include <algorithm>
#include <glm/ext/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

namespace psivox::view {
void Navigation::reset(const Scene& scene, const Subject& subject) {
  camera_ = make_camera(scene, subject);
  set_subject(subject);
  viewport_ = scene.resolution;
  tangent_ = std::tan(glm::radians(horizontal_fov(scene)) / 2);
  moved_ = false;
}

double Navigation::pivot_depth() const {
  return std::max(glm::dot(camera_.target - camera_.position, camera_.forward), 1e-4 * size());
}

double Navigation::half_width_at_pivot() const {
  return camera_.orthographic ? camera_.half_width : tangent_ * pivot_depth();
}

void Navigation::apply(Scene& scene) const {
  scene.projection = camera_.orthographic ? Projection::orthographic : Projection::perspective;
  if (!moved_) return;
  const double distance = pivot_depth();
  const double unit = 1e-6 * distance;
  scene.camera_position = rounded_to(camera_.position, unit);
  scene.camera_target = rounded_to(camera_.position + distance * camera_.forward, unit);
  // Near the poles the axis does not define which way is up.
  const bool pole = std::abs(glm::dot(camera_.forward, glm::normalize(camera_.camera_up))) > 0.999;
  scene.camera_up = pole ? rounded_to(camera_.up, 1e-6) : camera_.camera_up;
  Scene open = scene;
  open.camera_up.reset();
  if (*scene.camera_up == up_direction(open, subject_)) scene.camera_up.reset();
  scene.azimuth = scene.elevation = 0;
  scene.ortho_width.reset();
  if (camera_.orthographic)
    scene.ortho_width = rounded_to(2 * camera_.half_width * scene.zoom, 1e-6 * camera_.half_width);
}

void Navigation::turn(const glm::dvec3& about, double angle) {
  const glm::dmat3 rotation(glm::rotate(glm::dmat4(1), angle, about));
  camera_.position = camera_.target + rotation * (camera_.position - camera_.target);
  camera_.forward = glm::normalize(rotation * camera_.forward);
  camera_.right = rotation * camera_.right;
  camera_.right =
      glm::normalize(camera_.right - glm::dot(camera_.right, camera_.forward) * camera_.forward);
  camera_.up = glm::cross(camera_.right, camera_.forward);
  moved_ = true;
}

void Navigation::orbit(const glm::dvec2& pixels) {
  const glm::dvec3 axis = glm::normalize(camera_.camera_up);
  const double per_pixel = glm::radians(180.0) / std::max(viewport_.y, 1);
  turn(axis, -pixels.x * per_pixel);
  const double elevation = std::asin(std::clamp(glm::dot(camera_.forward, axis), -1.0, 1.0));
  const double limit = glm::radians(90.0);
  const double wanted = std::clamp(elevation - pixels.y * per_pixel, -limit, limit);
  turn(camera_.right, wanted - elevation);
}

void Navigation::shift(const glm::dvec3& by) {
  camera_.position += by;
  camera_.target += by;
  moved_ = true;
}

void Navigation::pan(const glm::dvec2& pixels) {
  const double per_pixel = 2 * half_width_at_pivot() / std::max(viewport_.x, 1);
  shift(per_pixel * (pixels.y * camera_.up - pixels.x * camera_.right));
}

void Navigation::dolly(double notches) {
  const double factor = std::pow(0.9, notches);
  if (camera_.orthographic)
    camera_.half_width *= factor;
  else
    camera_.position += pivot_depth() * (1 - factor) * camera_.forward;
  moved_ = true;
}

void Navigation::fly(const glm::dvec3& speed, double seconds) {
  const double scale = 0.5 * size() * seconds;
  shift(scale * (speed.x * camera_.right + speed.y * camera_.up + speed.z * camera_.forward));
}

void Navigation::frame_all() {
  const double aspect = double(viewport_.x) / std::max(viewport_.y, 1);
  const Framing framing = framing_of(subject_, {camera_.right, camera_.up, camera_.forward},
                                     tangent_, tangent_ / aspect, camera_.orthographic);
  camera_.target = framing.target;
  camera_.half_width = framing.half_width;
  camera_.position = camera_.target - framing.distance * camera_.forward;
  moved_ = true;
}

void Navigation::aim(const glm::dvec3& forward, const glm::dvec3& up) {
  const double depth = pivot_depth();
  camera_.forward = forward;
  camera_.right = glm::normalize(glm::cross(forward, up));
  camera_.up = glm::cross(camera_.right, forward);
  camera_.position = camera_.target - depth * forward;
  moved_ = true;
}

void Navigation::look(Axis axis, bool opposite) {
  const glm::dvec3 y = glm::normalize(camera_.camera_up);
  // The view from the front is along -Z if +Y is up, and along +Y if +Z is up.
  glm::dvec3 front =
      std::abs(y.z) > 0.9 ? glm::dvec3(0, y.z > 0 ? 1 : -1, 0) : glm::dvec3(0, 0, -1);
  front = glm::normalize(front - glm::dot(front, y) * y);
  const double sign = opposite ? -1 : 1;
  if (axis == Axis::top)
    aim(-sign * y, sign * front);
  else
    aim(axis == Axis::front ? sign * front : -sign * glm::cross(front, y), y);
}

void Navigation::face(const glm::dvec3& normal) {
  const glm::dvec3 unit = glm::normalize(normal), axis = glm::normalize(camera_.camera_up);
  const auto along = [&](const glm::dvec3& up) { return std::abs(glm::dot(up, unit)) > 0.999; };
  // where the axis and the picture's up direction are along the view too, any other will do
  const glm::dvec3 up = !along(axis) ? axis : !along(camera_.up) ? camera_.up : camera_.right;
  aim(glm::dot(unit, camera_.forward) < 0 ? -unit : unit, up);
}

void Navigation::toggle_projection() {
  const double depth = pivot_depth();
  if (camera_.orthographic)
    camera_.position += (depth - camera_.half_width / tangent_) * camera_.forward;
  else
    camera_.half_width = tangent_ * depth;
  camera_.orthographic = !camera_.orthographic;
  moved_ = true;
}

bool Navigation::project(const glm::dvec3& point, glm::dvec2& pixel) const {
  const glm::dvec3 q = point - camera_.position;
  const double depth = glm::dot(q, camera_.forward);
  if (!camera_.orthographic && depth < 1e-6 * size()) return false;
  const double half = camera_.orthographic ? camera_.half_width : tangent_ * depth;
  const double pixels = 0.5 * viewport_.x / half;
  pixel = {0.5 * viewport_.x + glm::dot(q, camera_.right) * pixels,
           0.5 * viewport_.y - glm::dot(q, camera_.up) * pixels};
  return true;
}

}  // namespace psivox::view
