// Compares the camera with the user guide's formulas, and the ray bundle with the camera.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <set>
#include <vector>

#include "expect_near.h"
#include "made_fields.h"
#include "march/pixel_box.h"
#include "psivox/camera.h"
#include "reference/ray_radiance.h"
#include "thrown.h"

namespace psivox {
namespace {

constexpr double pi = 3.14159265358979323846;

Camera camera_for(const Scene& scene) { return make_camera(scene, {-1, -2, -3}, {5, 4, 9}); }

/// Largest |x| and |y| of the box's corners on the image plane, as fractions of its half size.
glm::dvec2 frame_filled(const Camera& camera, const glm::dvec3& min, const glm::dvec3& max) {
  glm::dvec2 filled(0);
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 q =
        glm::dvec3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z) -
        camera.position;
    const double depth = camera.orthographic ? 1 : glm::dot(q, camera.forward);
    EXPECT_GT(depth, 0);
    filled.x = std::max(filled.x, std::abs(glm::dot(q, camera.right)) / depth / camera.half_width);
    filled.y = std::max(filled.y, std::abs(glm::dot(q, camera.up)) / depth / camera.half_height);
  }
  return filled;
}

TEST(Camera, DefaultLooksAlongMinusZAtTheWholeBox) {
  for (const glm::ivec2 resolution : {glm::ivec2(1280, 720), glm::ivec2(100, 700)}) {
    Scene scene;
    scene.resolution = resolution;
    const Camera camera = camera_for(scene);
    expect_near(camera.forward, {0, 0, -1}, 1e-15);
    expect_near(camera.right, {1, 0, 0}, 1e-15);
    expect_near(camera.up, {0, 1, 0}, 1e-15);
    expect_near(camera.target, {2, 1, 3}, 1e-15);
    const glm::dvec2 filled = frame_filled(camera, {-1, -2, -3}, {5, 4, 9});
    EXPECT_NEAR(std::max(filled.x, filled.y), 0.9, 1e-12);
  }
}

TEST(Camera, FieldOfViewComesFromTheLens) {
  Scene scene;
  EXPECT_NEAR(horizontal_fov(scene), 44.8, 0.01);  // vdb_render's default
  scene.focal_length = 10;
  scene.aperture = 20;
  EXPECT_NEAR(horizontal_fov(scene), 90, 1e-12);
  EXPECT_NEAR(camera_for(scene).half_width, 1, 1e-12);
  scene.fov = 60;
  EXPECT_NEAR(camera_for(scene).half_width, std::tan(pi / 6), 1e-15);
  for (const double fov : {1e-300, 179.9999999}) {
    scene.fov = fov;
    EXPECT_TRUE(has(usage_error([&] { camera_for(scene); }), "the field of view is "));
  }
  for (const double fov : {1e-100, 179.9999}) {
    scene.fov = fov;
    EXPECT_TRUE(std::isfinite(camera_for(scene).position.z)) << fov;
  }
}

TEST(Camera, OnlyATargetIsLookedAtAlongMinusZ) {
  Scene scene;
  scene.camera_target = glm::dvec3(4, 0, 1);
  const Camera camera = camera_for(scene);
  expect_near(camera.forward, {0, 0, -1}, 1e-15);
  EXPECT_EQ(camera.position.x, 4);
  EXPECT_EQ(camera.position.y, 0);
  const glm::dvec2 filled = frame_filled(camera, {-1, -2, -3}, {5, 4, 9});
  EXPECT_NEAR(std::max(filled.x, filled.y), 0.9, 1e-12);
}

TEST(Camera, OnlyAPositionLooksAtTheCentre) {
  Scene scene;
  scene.camera_position = glm::dvec3(-7, 12, 20);
  const Camera camera = camera_for(scene);
  expect_near(camera.target, {2, 1, 3}, 1e-15);
  expect_near(camera.forward, glm::normalize(glm::dvec3(9, -11, -17)), 1e-15);
  expect_near(camera.right, glm::normalize(glm::cross(camera.forward, glm::dvec3(0, 1, 0))), 1e-15);
  expect_near(camera.up, glm::cross(camera.right, camera.forward), 1e-15);
}

TEST(Camera, OrthographicFramesTheBox) {
  Scene scene;
  scene.projection = Projection::orthographic;
  scene.camera_position = glm::dvec3(30, 20, 10);
  const glm::dvec2 filled = frame_filled(camera_for(scene), {-1, -2, -3}, {5, 4, 9});
  EXPECT_NEAR(std::max(filled.x, filled.y), 0.9, 1e-12);
  scene.ortho_width = 3;
  EXPECT_EQ(camera_for(scene).half_width, 1.5);
  EXPECT_NEAR(camera_for(scene).half_height, 1.5 * 720 / 1280, 1e-15);
}

TEST(Camera, LookingAlongTheDefaultUpKeepsXOnTheRight) {
  for (const double side : {1.0, -1.0}) {
    Scene scene;
    scene.camera_position = glm::dvec3(2, 1 + 30 * side, 3);
    const Camera camera = camera_for(scene);
    expect_near(camera.forward, {0, -side, 0}, 1e-15);
    expect_near(camera.right, {1, 0, 0}, 1e-15);
    expect_near(camera.up, {0, 0, -side}, 1e-15);
  }
}

TEST(Camera, RefusesWhatHasNoPicture) {
  const auto refusal = [](const Scene& scene) { return usage_error([&] { camera_for(scene); }); };
  Scene scene;
  scene.camera_position = glm::dvec3(2, 1, 3);  // the box's centre
  EXPECT_NE(refusal(scene), "no error");
  scene.camera_position = glm::dvec3(2, 1, 30);
  EXPECT_EQ(refusal(scene), "no error");
  for (const glm::dvec3& up : {glm::dvec3(0, 0, 2), glm::dvec3(0)}) {
    scene.camera_up = up;
    EXPECT_NE(refusal(scene), "no error");
  }
  scene = {};
  scene.camera_position = glm::dvec3(1e300, 1e300, 0);
  EXPECT_NE(refusal(scene), "no error");
}

TEST(Camera, AVolumeThatNoCameraSeesIsTheFilesFault) {
  for (const double size : {1e-10, 1e300})
    EXPECT_NE(input_error([&] { make_camera({}, glm::dvec3(1e300), glm::dvec3(1e300 + size)); }),
              "no error");
}

TEST(CameraRay, IsTheConventionsFormula) {
  Scene scene;
  scene.resolution = {64, 48};
  scene.fov = 50;
  scene.camera_position = glm::dvec3(-7, 12, 20);
  const Camera c = camera_for(scene);
  const double tan_half = std::tan(25 * pi / 180);
  for (const glm::dvec2 pixel : {glm::dvec2(0.5, 0.5), {63.5, 0.5}, {10.25, 40.75}}) {
    const double a = (2 * pixel.x / 64 - 1) * tan_half;
    const double b = (1 - 2 * pixel.y / 48) * (48.0 / 64) * tan_half;
    const WorldRay ray = camera_ray(c, scene.resolution, pixel.x, pixel.y);
    expect_near(ray.origin, c.position, 0);
    expect_near(ray.direction, glm::normalize(c.forward + a * c.right + b * c.up), 1e-15);
  }
  scene.projection = Projection::orthographic;
  scene.ortho_width = 10;
  const Camera flat = camera_for(scene);
  const WorldRay corner = camera_ray(flat, scene.resolution, 0, 0);  // top left
  expect_near(corner.origin, flat.position - 5.0 * flat.right + 3.75 * flat.up, 1e-14);
  expect_near(corner.direction, flat.forward, 0);
}

TEST(CameraMatrices, PutThePointsOfARayInItsPixel) {
  for (const bool orthographic : {false, true}) {
    Scene scene;
    scene.resolution = {64, 36};
    scene.camera_position = {30, 12, -5};
    scene.camera_target = {1, 2, 3};
    if (orthographic) scene.projection = Projection::orthographic;
    const Camera camera = camera_for(scene);
    const CameraMatrices m = camera_matrices(camera);
    for (const glm::dvec2 pixel : {glm::dvec2(0, 0), {64, 36}, {12.5, 30.25}}) {
      const WorldRay ray = camera_ray(camera, scene.resolution, pixel.x, pixel.y);
      const glm::dvec4 point(ray.origin + 17.0 * ray.direction, 1);
      const glm::dvec4 ndc = m.world_to_ndc * point, seen = m.world_to_camera * point;
      // roundings of numbers up to 100
      EXPECT_NEAR(ndc.x / ndc.w, pixel.x / 64, 1e-13);
      EXPECT_NEAR(ndc.y / ndc.w, pixel.y / 36, 1e-13);
      EXPECT_NEAR(seen.z, glm::dot(glm::dvec3(point) - camera.position, camera.forward), 1e-13);
      EXPECT_EQ(seen.x > 1e-9, pixel.x > 32);  // to the right
      EXPECT_EQ(seen.y > 1e-9, pixel.y < 18);  // up
    }
  }
}

TEST(PixelSample, IsStratifiedForAnyCount) {
  EXPECT_EQ(pixel_sample(0, 1), glm::dvec2(0.5, 0.5));
  for (const int n : {2, 3, 4, 7, 16, 100}) {
    std::set<int> columns, rows;
    for (int i = 0; i < n; ++i) {
      const glm::dvec2 place = pixel_sample(i, n);
      columns.insert(static_cast<int>(place.x * n));
      rows.insert(static_cast<int>(place.y * n));
      EXPECT_TRUE(place.x > 0 && place.x < 1 && place.y > 0 && place.y < 1);
    }
    EXPECT_EQ(static_cast<int>(columns.size()), n);
    EXPECT_EQ(static_cast<int>(rows.size()), n);
  }
}

TEST(DefaultCamera, FramesABoxThatIsDrawnWithRoomForItsNumbers) {
  Scene scene;
  scene.box = true;
  const glm::dmat4 to_picture = camera_matrices(camera_for(scene)).world_to_ndc;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec4 at =
        to_picture * glm::dvec4(i & 1 ? 5 : -1, i & 2 ? 4 : -2, i & 4 ? 9 : -3, 1);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_GT(at[axis] / at.w, 0.03);  // of the picture's width or height
      EXPECT_LT(at[axis] / at.w, 0.97);
    }
  }
}

TEST(WorldBounds, HoldTheDomainOfARotatedGrid) {
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), pi / 4, glm::dvec3(0, 0, 1));
  const Field field = make_field(
      {{0, 0, 0}, {8, 8, 8}}, [](glm::ivec3) { return 1.f; }, turn);
  glm::dvec3 low, high;
  world_bounds(field, low, high);
  const double half = 10 * std::sqrt(0.5);
  expect_near(low, {-half, -std::sqrt(2.0), -1}, 1e-12);
  expect_near(high, {half, 9 * std::sqrt(2.0), 9}, 1e-12);
}

/// Grids whose transforms are rotated, sheared, tiny, huge or far from the world's origin.
std::vector<glm::dmat4> transforms() {
  const glm::dmat4 one(1);
  const glm::dmat4 turn = glm::rotate(one, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
  glm::dmat4 shear = glm::scale(one, glm::dvec3(0.1, 0.25, 2));
  shear[1][0] = 0.07;
  shear[2][1] = -0.4;
  return {one, glm::scale(one, glm::dvec3(1e-4)), glm::scale(one, glm::dvec3(1e4)), turn * shear,
          glm::translate(one, glm::dvec3(1e6, -1e6, 1e6)) * turn * shear};
}

TEST(RayBundle, IsTheCamerasRayInIndexSpace) {
  for (const glm::dmat4& world_from_index : transforms()) {
    const Field centre = make_field(
        {{-3, 4, 90}, {40, 20, 120}}, [](glm::ivec3) { return 1.f; }, world_from_index);
    const glm::dmat4 other = world_from_index * glm::scale(glm::dmat4(1), glm::dvec3(0.5, 2, 1));
    const Field field = make_field(
        {{5, 5, 5}, {21, 9, 40}}, [](glm::ivec3) { return 1.f; }, other);
    glm::dvec3 low, high;
    world_bounds(centre, low, high);
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      for (const bool inside : {false, true}) {
        Scene scene;
        scene.resolution = {64, 48};
        scene.projection = projection;
        // Inside the box and looking away from its middle: the anchor plane is the camera's own.
        if (inside) {
          scene.camera_position = low + 0.7 * (high - low);
          scene.camera_target = low + glm::dvec3(0.9, 0.8, 1.0) * (high - low);
        }
        const Camera camera = make_camera(scene, low, high);
        const RayBundle bundle = make_ray_bundle(camera, field, centre);
        EXPECT_EQ(bundle.orthographic, projection == Projection::orthographic);
        EXPECT_EQ(bundle.origin % 8, glm::ivec3(0));
        EXPECT_EQ(bundle.distance == 0, inside);
        const glm::dmat4 index_from_world = glm::inverse(other);
        for (const glm::dvec2 pixel : {glm::dvec2(32, 24), {0.5, 0.5}, {63.5, 7.25}}) {
          const WorldRay ray = camera_ray(camera, scene.resolution, pixel.x, pixel.y);
          const double u = 2 * pixel.x / 64 - 1, v = 1 - 2 * pixel.y / 48;
          const glm::dvec3 w = bundle.world_0 + u * bundle.world_u + v * bundle.world_v;
          const double s = 1 / glm::length(w);
          expect_near(s * w, ray.direction, 1e-14);
          const glm::dvec3 anchor = bundle.anchor_0 + u * bundle.anchor_u + v * bundle.anchor_v;
          const glm::dvec3 direction =
              s * (bundle.direction_0 + u * bundle.direction_u + v * bundle.direction_v);
          const double camera_t = -bundle.distance / s * (bundle.orthographic ? s : 1);
          const double size = glm::length(high - low);
          for (const double t : {0.0, 0.3 * size, 2 * size}) {
            const glm::dvec3 world = ray.origin + t * ray.direction;
            const glm::dvec3 expected(index_from_world * glm::dvec4(world, 1));
            const glm::dvec3 got = anchor + (camera_t + t) * direction + glm::dvec3(bundle.origin);
            // World coordinates carry a rounding error of 1e-16 of their size.
            const double rounding =
                1e-15 * glm::length(world) *
                glm::length(index_from_world[0] + index_from_world[1] + index_from_world[2]);
            expect_near(got, expected,
                        1e-9 * glm::length(expected - glm::dvec3(bundle.origin)) + 8 * rounding);
          }
        }
      }
    }
  }
}

// The box's edges are projected, rays meet the box: two ways to the same pixels.
TEST(PixelBox, HoldsAllWhoseRaysMeetABox) {
  const Field field = make_field({{-9, 3, 4}, {22, 15, 31}}, [](glm::ivec3) { return 1.0f; });
  const Box domain = field.domain();
  const glm::dvec3 low(domain.min), high(domain.max), middle = 0.5 * (low + high);
  constexpr int side = 160;
  int inside = 0, smaller = 0;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 away(std::cos(i), std::sin(2.4 * i), std::sin(i));
    const double distance = 10 + 3 * i;  // the first cameras are inside
    Scene scene = looking(small_scene(side), middle + distance * away,
                          middle + 20.0 * glm::dvec3(std::sin(5 * i), 0.3, std::cos(3 * i)),
                          i % 3 == 0 ? std::optional<double>(70) : std::nullopt);
    scene.extinction = 1;
    const bool cells = i % 2 == 1;  // voxels are, each around its first corner
    if (cells) scene.classification = Classification::nearest;
    const View view = view_of(scene, field);
    const PixelBox box = pixels_of(view, low, high);
    smaller += !box.empty() && box.size != view.scene.resolution;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        WorldRay ray = pixel_ray(view, x, y);
        if (cells) ray.origin += 0.5;
        const glm::dvec3 to_low = (low - ray.origin) / ray.direction,
                         to_high = (high - ray.origin) / ray.direction;
        const glm::dvec3 enters = glm::min(to_low, to_high), leaves = glm::max(to_low, to_high);
        const double begin = std::max({0.0, enters.x, enters.y, enters.z});
        if (begin > std::min({leaves.x, leaves.y, leaves.z})) continue;
        ++inside;
        EXPECT_FALSE(common(box, {{x, y}, {1, 1}}).empty()) << i << ": " << x << ' ' << y;
      }
  }
  EXPECT_GT(inside, 10000);
  EXPECT_GT(smaller, 20);
}

}  // namespace
}  // namespace psivox
