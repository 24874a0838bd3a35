// What the automatic camera has in frame, and how its angles turn it.

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "expect_near.h"
#include "made_fields.h"
#include "psivox/medium.h"
#include "psivox/picture_file.h"

namespace psivox {
namespace {

Scene picture() {
  Scene scene;
  scene.resolution = {160, 90};
  scene.extinction = 1;
  return scene;
}

constexpr glm::dvec3 middle(28, 30, 31);
constexpr double radius = 24;

float ball(const glm::ivec3& v) {
  return glm::length(glm::dvec3(v) - middle) < radius ? 1.0f : 0.0f;
}

/// Least and greatest x and y of the ball's surface in the picture, as parts of its half sizes.
struct Extent {
  glm::dvec2 low{1e9}, high{-1e9};
};

Extent extent_of(const Camera& camera) {
  Extent extent;
  for (int i = 0; i < 4000; ++i) {  // Fibonacci's lattice on the sphere
    const double z = 1 - (2 * i + 1) / 4000.0, angle = 2.399963229728653 * i;
    const double r = std::sqrt(1 - z * z);
    const glm::dvec3 q =
        middle + radius * glm::dvec3(r * std::cos(angle), r * std::sin(angle), z) - camera.position;
    const double depth = camera.orthographic ? 1 : glm::dot(q, camera.forward);
    const glm::dvec2 place(glm::dot(q, camera.right) / (depth * camera.half_width),
                           glm::dot(q, camera.up) / (depth * camera.half_height));
    extent.low = glm::min(extent.low, place);
    extent.high = glm::max(extent.high, place);
  }
  return extent;
}

Camera camera_of(Scene scene, Field field) { return view_of(scene, std::move(field)).camera; }

TEST(Framing, KeepsACompactBodyWholeAndFillsTheFrame) {
  const Field field = make_field({{0, 0, 0}, {60, 60, 60}}, ball);
  for (const glm::ivec2 resolution : {glm::ivec2(160, 90), glm::ivec2(50, 200)}) {
    Scene scene = picture();
    scene.resolution = resolution;
    const Extent extent = extent_of(camera_of(scene, field));
    const double reached = std::max({-extent.low.x, extent.high.x, -extent.low.y, extent.high.y});
    EXPECT_LE(reached, 0.9 + 1e-9);  // the margin is 0.1
    EXPECT_GE(reached, 0.7);         // leaves are boxes of up to 8 voxels
    EXPECT_NEAR(extent.low.x, -extent.high.x, 0.1);
    EXPECT_NEAR(extent.low.y, -extent.high.y, 0.1);
  }
}

TEST(Framing, LeavesAStripForTheColourBar) {
  const Field field = make_field({{0, 0, 0}, {60, 60, 60}}, ball);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    Scene scene = picture();
    scene.resolution = {200, 200};
    scene.projection = projection;
    scene.azimuth = 30;
    scene.colormap = Colormap::viridis;
    const Extent whole = extent_of(camera_of(scene, field));
    scene.color_bar = "";
    const Extent extent = extent_of(camera_of(scene, field));
    const double right_end = 1 - 2 * color_bar_strip(scene.resolution) / 200.0;
    EXPECT_LT(right_end, 0.5);
    EXPECT_LT(extent.high.x, right_end);
    EXPECT_GT(extent.low.x, -1);
    // as large as fits, in the middle of what is free
    EXPECT_NEAR(extent.high.x - extent.low.x, (whole.high.x - whole.low.x) * (1 + right_end) / 2,
                0.1 * (1 + right_end));
    EXPECT_NEAR(extent.high.x + extent.low.x, right_end - 1, 0.1);
  }
}

TEST(Framing, AGivenCameraIsNotMovedForTheColourBar) {
  Scene scene = picture();
  scene.resolution = {200, 200};
  scene.colormap = Colormap::viridis;
  scene.camera_position = glm::dvec3(28, 30, 200);
  scene.camera_target = middle;
  const Field field = make_field({{0, 0, 0}, {60, 60, 60}}, ball);
  const Extent before = extent_of(camera_of(scene, field));
  scene.color_bar = "";
  EXPECT_EQ(extent_of(camera_of(scene, field)).high, before.high);
}

TEST(Framing, StrayVoxelsAndFaintOnesDoNotCount) {
  const Field alone = make_field({{0, 0, 0}, {60, 60, 60}}, ball);
  const Camera expected = camera_of(picture(), alone);

  Field faint = make_field({{0, 0, 0}, {60, 60, 60}},
                           [](glm::ivec3 v) { return std::max(ball(v), 0.0005f); });
  Camera camera = camera_of(picture(), faint);
  expect_near(camera.position, expected.position, 1e-9);

  Field speck = make_field({{0, 0, 0}, {60, 60, 60}}, [](glm::ivec3 v) {
    return v == glm::ivec3(30, 30, 30) ? 1e5f : ball(v);
  });
  camera = camera_of(picture(), speck);
  expect_near(camera.position, expected.position, 1e-9);

  // Stray voxels far away along each of the picture's axes: with the voxel around them that is
  // interpolated, 1 or 3 % of the ball's picture of 1,800 voxels.
  for (const auto& [far, size] : {std::pair(glm::ivec3(5000, 30, 30), 2),
                                  {{30, -4000, 30}, 2},
                                  {{20, 24, 3000}, 2},
                                  {{5000, 30, 30}, 5}}) {
    const Field stray = make_field({far, far + (size - 1)}, [](glm::ivec3) { return 1.0f; });
    Field both = alone;
    both.active_box = {glm::min(alone.active_box.min, far),
                       glm::max(alone.active_box.max, far + size)};
    both.leaves.insert(both.leaves.end(), stray.leaves.begin(), stray.leaves.end());
    both.storage = std::make_shared<std::pair<Storage, Field>>(alone.storage, stray);
    camera = camera_of(picture(), both);
    const Extent extent = extent_of(camera);
    // What is left out may add a quarter of the body on either side.
    EXPECT_LE(std::max({-extent.low.x, extent.high.x, -extent.low.y, extent.high.y}), 0.9);
    EXPECT_GE(std::max(extent.high.x - extent.low.x, extent.high.y - extent.low.y), 0.9);
  }
}

TEST(Framing, SeesWhatTheFunctionOfTheValueShows) {
  // A mode that shows values above 0.5 only frames the inner ball.
  const Field field = make_field({{0, 0, 0}, {60, 60, 60}}, [](glm::ivec3 v) {
    return glm::length(glm::dvec3(v) - middle) < radius ? 1.0f : 0.4f;
  });
  Scene scene = picture();
  scene.mode = Mode::isosurface;
  scene.isovalue = {{0.5}};
  scene.extinction.reset();
  const Extent extent = extent_of(camera_of(scene, field));
  EXPECT_GE(extent.high.y - extent.low.y, 1.4);
}

TEST(Framing, SeesWhatASurfaceBelowZeroEncloses) {
  const auto ball_of = [](float sign) {
    return make_field({{0, 0, 0}, {60, 60, 60}}, [sign](glm::ivec3 v) {
      return glm::length(glm::dvec3(v) - middle) < radius ? sign : 0.0f;
    });
  };
  Scene scene = picture();
  scene.mode = Mode::isosurface;
  scene.extinction.reset();
  scene.isovalue = {{0.5}};
  const Camera above = camera_of(scene, ball_of(1));
  scene.isovalue = {{-0.5}};
  EXPECT_EQ(camera_of(scene, ball_of(-1)).position, above.position);
}

TEST(Framing, SeesAnEmissionGridBeyondTheDensity) {
  const Field density = make_field({{0, 0, 0}, {60, 60, 60}}, ball);
  const Field fire = make_field({{0, 60, 0}, {40, 100, 40}}, [](glm::ivec3) { return 1.0f; });
  const View view = make_view(
      picture(),
      MediumFields{share(density), nullptr, nullptr, {{&emission_options[0], share(fire)}}});
  const Camera& camera = view.camera;
  for (const double y : {middle.y - radius, 100.0}) {
    const glm::dvec3 q = glm::dvec3(20, y, y == 100 ? 40 : middle.z) - camera.position;
    EXPECT_LE(std::abs(glm::dot(q, camera.up)) / glm::dot(q, camera.forward), camera.half_height);
  }
}

TEST(Framing, OfATurnedGridUsesItsOwnBox) {
  // The corner of a turned box is at the frame's border, not the corner of the box around it.
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
  const Box box{{0, 0, 0}, {39, 31, 23}};
  const Camera camera = camera_of(picture(), make_field(
                                                 box, [](glm::ivec3) { return 1.0f; }, turn));
  double reached = 0;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner(i & 1 ? 40 : -1, i & 2 ? 32 : -1, i & 4 ? 24 : -1);
    const glm::dvec3 q = glm::dvec3(turn * glm::dvec4(corner, 1)) - camera.position;
    const double depth = glm::dot(q, camera.forward);
    reached = std::max({reached, std::abs(glm::dot(q, camera.right)) / depth / camera.half_width,
                        std::abs(glm::dot(q, camera.up)) / depth / camera.half_height});
  }
  // Bounds of leaves' parts of the box may stand out of it by less than a voxel's diagonal.
  EXPECT_LE(reached, 0.9 + 1e-9);
  EXPECT_GE(reached, 0.85);
}

TEST(CameraAngles, TurnAsVtksDo) {
  const auto looking_from = [](double azimuth, double elevation) {
    Scene scene;
    scene.azimuth = azimuth;
    scene.elevation = elevation;
    const Camera camera = make_camera(scene, glm::dvec3(-1), glm::dvec3(1));
    EXPECT_NEAR(glm::dot(camera.right, camera.up), 0, 1e-12);
    return camera;
  };
  expect_near(looking_from(90, 0).forward, {-1, 0, 0}, 1e-12);  // the eye is at +X
  expect_near(looking_from(0, 90).forward, {0, -1, 0}, 1e-12);  // above
  expect_near(looking_from(0, 90).up, {0, 0, -1}, 1e-12);
  expect_near(looking_from(90, 90).up, {-1, 0, 0}, 1e-12);
  expect_near(looking_from(0, 120).up, glm::normalize(glm::dvec3(0, -0.5, -std::sqrt(0.75))),
              1e-12);
  const double s = std::sqrt(0.5);
  expect_near(looking_from(45, 30).forward, {-s * std::sqrt(0.75), -0.5, -s * std::sqrt(0.75)},
              1e-12);
}

TEST(CameraAngles, TurnAGivenCameraAboutItsTarget) {
  Scene scene;
  scene.camera_position = glm::dvec3(5, 3, 13);
  scene.camera_target = glm::dvec3(5, 3, 3);
  scene.azimuth = -90;
  expect_near(make_camera(scene, glm::dvec3(-1), glm::dvec3(1)).position, {-5, 3, 3}, 1e-12);
}

TEST(CameraAngles, ZoomNarrowsTheView) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    Scene scene;
    scene.projection = projection;
    const Camera wide = make_camera(scene, glm::dvec3(-1), glm::dvec3(1));
    scene.zoom = 2.5;
    const Camera narrow = make_camera(scene, glm::dvec3(-1), glm::dvec3(1));
    expect_near(narrow.position, wide.position, 1e-12);
    EXPECT_NEAR(narrow.half_width * 2.5, wide.half_width, 1e-12);
    EXPECT_NEAR(narrow.half_height * 2.5, wide.half_height, 1e-12);
  }
}

TEST(UpAxis, ZIsSeenFromTheFrontAsInBlender) {
  const auto subject = [](const char* z_up) {
    Subject box = box_subject(glm::dvec3(-1), glm::dvec3(1));
    box.z_up = z_up;
    return box;
  };
  Scene scene;
  for (const bool by_file : {true, false}) {
    scene.up_axis = by_file ? UpAxis::automatic : UpAxis::z;
    const Camera camera = make_camera(scene, subject(by_file ? "written by Blender" : ""));
    expect_near(camera.forward, {0, 1, 0}, 1e-12);
    expect_near(camera.right, {1, 0, 0}, 1e-12);
    expect_near(camera.up, {0, 0, 1}, 1e-12);
  }
  scene.up_axis = UpAxis::y;
  expect_near(make_camera(scene, subject("written by Blender")).forward, {0, 0, -1}, 1e-12);
  scene.up_axis = UpAxis::automatic;
  scene.camera_up = glm::dvec3(0, 0, 1);  // says it, too
  expect_near(make_camera(scene, subject("")).forward, {0, 1, 0}, 1e-12);
}

TEST(ResolvedScene, GivesTheSameCamera) {
  const auto field = share(make_field({{0, 0, 0}, {60, 60, 60}}, ball));
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    for (const double elevation : {0.0, 25.0, 90.0, 130.0}) {
      Scene scene = picture();
      scene.projection = projection;
      scene.azimuth = 33;
      scene.elevation = elevation;
      scene.zoom = 1.7;
      scene.up_axis = elevation == 25 ? UpAxis::z : UpAxis::automatic;
      const View first = view_of(scene, field);
      const View again = view_of(first.scene, field);
      EXPECT_EQ(first.camera.position, again.camera.position);
      EXPECT_EQ(first.camera.forward, again.camera.forward);
      EXPECT_EQ(first.camera.half_width, again.camera.half_width);
      expect_near(first.camera.right, again.camera.right, 1e-15);
    }
  }
}

}  // namespace
}  // namespace psivox
