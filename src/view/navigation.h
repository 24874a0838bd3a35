#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "psivox/camera.h"

namespace psivox::view {

/// Views along an axis, as Blender's 1, 3 and 7: from the front, from the right, from above.
enum class Axis { front, right, top };

/// The camera that the user moves: a turntable around the scene's up direction, with a pivot that
/// need not be in the middle of the picture. It knows nothing of GL or windows. Pixels are the
/// window's.
class Navigation {
 public:
  /// Takes the scene's own camera. Throws what make_camera throws.
  void reset(const Scene& scene, const Subject& subject);
  /// Another volume; the camera stays.
  void set_subject(const Subject& subject) { subject_ = subject; }
  void set_viewport(const glm::ivec2& pixels) { viewport_ = pixels; }

  /// Writes the camera into the scene if it was moved. Numbers are rounded to a millionth of the
  /// distance, which keeps command lines short.
  void apply(Scene& scene) const;
  bool moved() const { return moved_; }
  /// Keeps the camera as it is, whatever volume follows.
  void hold() { moved_ = true; }

  void orbit(const glm::dvec2& pixels);  ///< right and down
  void pan(const glm::dvec2& pixels);    ///< the plane through the pivot follows the pointer
  void dolly(double notches);            ///< towards the pivot, by a tenth of its depth each
  /// `speed` is along right, up and forward; at speed 1 a flight crosses the box in two seconds.
  void fly(const glm::dvec3& speed, double seconds);
  /// Keeps the direction and brings all that is visible into frame.
  void frame_all();
  /// Keeps the pivot and its distance; `opposite`: from the back, the left, below.
  void look(Axis axis, bool opposite);
  /// Looks along a plane's normal, from the side that is nearer. Keeps the pivot and its distance.
  void face(const glm::dvec3& normal);
  const glm::dvec3& forward() const { return camera_.forward; }
  /// Perspective or orthographic; the plane through the pivot keeps its size.
  void toggle_projection();
  /// The point that orbits turn around; the picture stays.
  void set_pivot(const glm::dvec3& point) { camera_.target = point; }
  const glm::dvec3& pivot() const { return camera_.target; }

  /// Place of a world point in the window; false if it is behind the camera.
  bool project(const glm::dvec3& point, glm::dvec2& pixel) const;

 private:
  double size() const { return glm::length(subject_.box_max - subject_.box_min); }
  double pivot_depth() const;
  double half_width_at_pivot() const;
  void turn(const glm::dvec3& about, double angle);
  void shift(const glm::dvec3& by);
  /// Looks at the pivot along a unit vector, from the distance that it has.
  void aim(const glm::dvec3& forward, const glm::dvec3& up);

  Subject subject_ = box_subject(glm::dvec3(-1), glm::dvec3(1));
  /// Its target is the pivot, its `camera_up` the turntable's axis.
  Camera camera_{{0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  double tangent_ = 0.4;  ///< of half the horizontal field of view
  glm::ivec2 viewport_{1280, 720};
  bool moved_ = false;
};

/// Rounds to a multiple of the largest power of ten that is at most `unit`, which keeps command
/// lines short.
inline double rounded_to(double value, double unit) {
  const double digits = std::pow(10.0, std::ceil(-std::log10(unit)));
  // + 0: -0 is 0
  return std::isfinite(digits) && digits > 0 ? std::round(value * digits) / digits + 0.0 : value;
}

inline glm::dvec3 rounded_to(const glm::dvec3& value, double unit) {
  return {rounded_to(value.x, unit), rounded_to(value.y, unit), rounded_to(value.z, unit)};
}

}  // namespace psivox::view
