#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

#include "scene/transfer_function.h"
#include "verify/case.h"
#include "verify/made_fields.h"
#include "verify/made_views.h"

// One medium, given in several ways, must give one picture.

namespace psivox {
namespace {

/// Two balls in a box of 40 x 36 x 38 voxels. The larger is flat inside, so some bricks have a
/// single value.
double balls_at(const glm::dvec3& p) {
  const auto ball = [&](const glm::dvec3& c, double r) {
    return std::max(0.0, 1 - glm::dot(p - c, p - c) / (r * r));
  };
  return std::min(1.0, 2 * ball({18, 17, 17}, 18)) + 0.8 * ball({31, 8, 29}, 7);
}
Field balls(const glm::ivec3& at = {0, 0, 0}, const glm::dmat4& m = glm::dmat4(1)) {
  return make_field(
      {at, at + glm::ivec3(39, 35, 37)},
      [at](glm::ivec3 v) { return float(balls_at(glm::dvec3(v - at))); }, m);
}

// Rays are placed to 64 * 2^-24 voxels: coordinates of at most 32 from the middle are rounded by 16
// * 2^-24, twice, in two pictures. Along a ray the balls rise and fall by 1 and by 0.8, at most
// 0.23 per voxel, and K = 0.1. R is at most 1.8, the largest L; it changes by twice the change of
// the depth, plus the change of L.
constexpr double change_per_voxel = 2 * 1.8 * 0.1 * 2 * (1 + 0.8) + 0.23;
constexpr double place_bound = 64 * 0x1p-24 * change_per_voxel;
constexpr char place_reason[] = "rays placed to 64 * 2^-24 voxels, 1.5 of radiance a voxel";

Scene oblique(std::optional<double> step) {
  Scene scene = looking(small_scene(32, 0.1), {95, 60, 70}, {20, 18, 19}, 60.0);
  scene.step = step;
  return scene;
}

/// Compares the balls' picture with that of another field, as many times as large and moved.
Case same_as_balls(const std::string& name, const std::function<Field()>& other, double scale = 1,
                   const glm::dvec3& origin = {0, 0, 0}) {
  return {name, place_reason, place_bound, [=](const Painter& painter) {
            Measured found;
            for (const std::optional<double> step : {std::optional<double>(), std::optional(0.9)}) {
              Scene scene = oblique(step);
              const Image expected = painter.picture(view_of(scene, balls(), Glow::density));
              for (auto* p : {&scene.camera_position, &scene.camera_target})
                *p = origin + scale * **p;
              *scene.extinction /= scale;
              *scene.ortho_width *= scale;
              const Image image = painter.picture(view_of(scene, other(), Glow::density));
              // three axes, two pictures
              found.add({picture_difference(expected, image), 3 * 2 * change_per_voxel});
            }
            return found;
          }};
}

/// x' = -y, y' = x; the transform turns it back.
Field turned_balls() {
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), glm::radians(90.0), glm::dvec3(0, 0, 1));
  return make_field(
      {{-35, 0, 0}, {0, 39, 37}},
      [](glm::ivec3 v) { return float(balls_at(glm::dvec3(v.y, -v.x, v.z))); }, glm::inverse(turn));
}

/// From the other end the same segments are composited, whose sums are rounded otherwise: 256 of
/// them to 16 roundings, in each picture.
constexpr double order_bound = 2 * 16 * 0x1p-24 * 1.8;

/// The pictures of a row of cameras, whose rays meet the domain's faces in many ways.
Measured back_to_front(const Painter& painter) {
  const auto field = share(balls());
  const auto function = std::make_shared<const TransferFunction>(
      std::vector<TransferPoint>{{0.1, 0, {}}, {0.4, 1, {}}, {0.7, 0.2, {}}}, false);
  Measured found;
  for (int turn = 0; turn < 6; ++turn) {
    Scene scene = looking(small_scene(32, 0.1), {20, 18, 90}, {20, 18, 19});
    scene.azimuth = 13 + 20 * turn;
    scene.elevation = 20;
    View view = view_of(scene, field, Glow::density);
    view.medium.transfer = function;
    const Image front = painter.picture(view);
    view.scene.mode = Mode::back_to_front;
    // three axes, two pictures; the function's slope is at most 1/0.3
    found.add({picture_difference(front, painter.picture(view)), 3 * 2 * change_per_voxel / 0.3});
  }
  return found;
}

}  // namespace

std::vector<Case> invariance_cases() {
  const auto moved_balls = [](const glm::ivec3& at, const glm::dvec3& origin, double scale = 1) {
    return [=] {
      return balls(at, glm::scale(glm::translate(glm::dmat4(1), origin), glm::dvec3(scale)));
    };
  };
  const glm::ivec3 shift(3, -5, 7);
  const glm::dvec3 away(1e6, -1e6, 1e6);
  return {
      same_as_balls("shifted against the bricks", moved_balls(shift, -glm::dvec3(shift))),
      same_as_balls("quarter turn", turned_balls),
      same_as_balls("balls 1e4 as large, 1e6 away", moved_balls({0, 0, 0}, away, 1e4), 1e4, away),
      same_as_balls("tiles as voxels", [] { return with_tiles(balls()); }),
      {"back to front", "the same segments from either end: twice 16 roundings of 2^-24",
       order_bound, back_to_front},
  };
}

}  // namespace psivox
