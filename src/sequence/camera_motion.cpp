#include "psivox/camera_motion.h"

#include <algorithm>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace psivox {

Scene turned(Scene scene, double angle) {
  const glm::dvec3 up = glm::normalize(*scene.camera_up);
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), glm::radians(angle), up));
  scene.camera_position =
      *scene.camera_target + turn * (*scene.camera_position - *scene.camera_target);
  return scene;
}

Scene framed_for_turn(const Scene& scene, const Subject& subject) {
  if (scene.camera_position) return scene;
  constexpr int sides = 24;
  Scene framed = scene;
  if (!framed.camera_target) framed.camera_target = middle_of(subject);
  Camera farthest;
  double distance = -1;
  for (int i = 0; i < sides; ++i) {
    framed.azimuth = scene.azimuth + 360.0 * i / sides;
    const Camera camera = make_camera(framed, subject);
    const double away = glm::length(camera.position - camera.target);
    if (away <= distance && camera.half_width <= farthest.half_width) continue;
    distance = std::max(distance, away);
    farthest.half_width = std::max(i ? farthest.half_width : 0, camera.half_width);
  }
  framed.azimuth = scene.azimuth;
  const Camera first = make_camera(framed, subject);
  keep_camera(framed, first);
  framed.camera_position = first.target - distance * first.forward;
  if (first.orthographic) framed.ortho_width = 2 * farthest.half_width;
  return framed;
}

View followed(View view) {
  Scene own = view.scene;
  own.camera_position.reset();
  own.camera_target.reset();
  const glm::dvec3 target = make_camera(own, *view.subject).target;
  const glm::dvec3 away = view.camera.position - view.camera.target;
  view.scene.camera_target = target;
  view.scene.camera_position = target + away;
  view.camera = make_camera(view.scene, *view.subject);
  return view;
}

}  // namespace psivox
