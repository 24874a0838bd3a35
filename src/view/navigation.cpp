#include "view/navigation.h"

#include <algorithm>
#include <glm/ext/matrix_transform.hpp>
#include <glm/trigonometric.hpp>

namespace psivox::view {
void Navigation::reset(const Scene& scene, const Subject& subject) {
  const Camera camera = make_camera(scene, subject);
  set_subject(subject);
  viewport_ = scene.resolution;
  position_ = camera.position;
  right_ = camera.right;
  up_ = camera.up;
  forward_ = camera.forward;
  pivot_ = camera.target;
  scene_up_ = camera.camera_up;
  tangent_ = std::tan(glm::radians(horizontal_fov(scene)) / 2);
  orthographic_ = camera.orthographic;
  half_width_ = camera.half_width;
  moved_ = false;
}

double Navigation::pivot_depth() const {
  return std::max(glm::dot(pivot_ - position_, forward_), 1e-4 * size());
}

double Navigation::half_width_at_pivot() const {
  return orthographic_ ? half_width_ : tangent_ * pivot_depth();
}

void Navigation::apply(Scene& scene) const {
  scene.projection = orthographic_ ? Projection::orthographic : Projection::perspective;
  if (!moved_) return;
  const double distance = pivot_depth();
  const double unit = 1e-6 * distance;
  scene.camera_position = rounded_to(position_, unit);
  scene.camera_target = rounded_to(position_ + distance * forward_, unit);
  // Near the poles the axis does not define which way is up.
  const bool pole = std::abs(glm::dot(forward_, glm::normalize(scene_up_))) > 0.999;
  scene.camera_up = pole ? rounded_to(up_, 1e-6) : scene_up_;
  Scene open = scene;
  open.camera_up.reset();
  if (*scene.camera_up == up_direction(open, subject_)) scene.camera_up.reset();
  scene.azimuth = scene.elevation = 0;
  scene.ortho_width.reset();
  if (orthographic_)
    scene.ortho_width = rounded_to(2 * half_width_ * scene.zoom, 1e-6 * half_width_);
}

void Navigation::turn(const glm::dvec3& about, double angle) {
  const glm::dmat3 rotation(glm::rotate(glm::dmat4(1), angle, about));
  position_ = pivot_ + rotation * (position_ - pivot_);
  forward_ = glm::normalize(rotation * forward_);
  right_ = rotation * right_;
  right_ = glm::normalize(right_ - glm::dot(right_, forward_) * forward_);
  up_ = glm::cross(right_, forward_);
  moved_ = true;
}

void Navigation::orbit(const glm::dvec2& pixels) {
  const glm::dvec3 axis = glm::normalize(scene_up_);
  const double per_pixel = glm::radians(180.0) / std::max(viewport_.y, 1);
  turn(axis, -pixels.x * per_pixel);
  const double elevation = std::asin(std::clamp(glm::dot(forward_, axis), -1.0, 1.0));
  const double limit = glm::radians(90.0);
  const double wanted = std::clamp(elevation - pixels.y * per_pixel, -limit, limit);
  turn(right_, wanted - elevation);
}

void Navigation::shift(const glm::dvec3& by) {
  position_ += by;
  pivot_ += by;
  moved_ = true;
}

void Navigation::pan(const glm::dvec2& pixels) {
  const double per_pixel = 2 * half_width_at_pivot() / std::max(viewport_.x, 1);
  shift(per_pixel * (pixels.y * up_ - pixels.x * right_));
}

void Navigation::dolly(double notches) {
  const double factor = std::pow(0.9, notches);
  if (orthographic_)
    half_width_ *= factor;
  else
    position_ += pivot_depth() * (1 - factor) * forward_;
  moved_ = true;
}

void Navigation::fly(const glm::dvec3& speed, double seconds) {
  const double scale = 0.5 * size() * seconds;
  shift(scale * (speed.x * right_ + speed.y * up_ + speed.z * forward_));
}

void Navigation::frame_all() {
  const double aspect = double(viewport_.x) / std::max(viewport_.y, 1);
  const Framing framing =
      framing_of(subject_, {right_, up_, forward_}, tangent_, tangent_ / aspect, orthographic_);
  pivot_ = framing.target;
  half_width_ = framing.half_width;
  position_ = pivot_ - framing.distance * forward_;
  moved_ = true;
}

void Navigation::aim(const glm::dvec3& forward, const glm::dvec3& up) {
  const double depth = pivot_depth();
  forward_ = forward;
  right_ = glm::normalize(glm::cross(forward, up));
  up_ = glm::cross(right_, forward);
  position_ = pivot_ - depth * forward;
  moved_ = true;
}

void Navigation::look(Axis axis, bool opposite) {
  const glm::dvec3 y = glm::normalize(scene_up_);
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
  const glm::dvec3 unit = glm::normalize(normal), axis = glm::normalize(scene_up_);
  const auto along = [&](const glm::dvec3& up) { return std::abs(glm::dot(up, unit)) > 0.999; };
  // where the axis and the picture's up direction are along the view too, any other will do
  const glm::dvec3 up = !along(axis) ? axis : !along(up_) ? up_ : right_;
  aim(glm::dot(unit, forward_) < 0 ? -unit : unit, up);
}

void Navigation::toggle_projection() {
  const double depth = pivot_depth();
  if (orthographic_)
    position_ += (depth - half_width_ / tangent_) * forward_;
  else
    half_width_ = tangent_ * depth;
  orthographic_ = !orthographic_;
  moved_ = true;
}

bool Navigation::project(const glm::dvec3& point, glm::dvec2& pixel) const {
  const glm::dvec3 q = point - position_;
  const double depth = glm::dot(q, forward_);
  if (!orthographic_ && depth < 1e-6 * size()) return false;
  const double half = orthographic_ ? half_width_ : tangent_ * depth;
  const double pixels = 0.5 * viewport_.x / half;
  pixel = {0.5 * viewport_.x + glm::dot(q, right_) * pixels,
           0.5 * viewport_.y - glm::dot(q, up_) * pixels};
  return true;
}

}  // namespace psivox::view
