// --clip, --clip-plane and --mode slice, by every marcher.

#include "scene/cuts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "made_fields.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

/// Density 1 in a cube from 0 to 31 along each axis.
Field cube() {
  return make_field({{0, 0, 0}, {31, 31, 31}}, [](glm::ivec3) { return 1.0f; });
}

Scene along_z() {
  Scene scene = looking(small_scene(16), {16, 15, 200}, {16, 15, 15}, 4.0);
  scene.extinction = 0.05;
  return scene;
}

float alpha_of(const Scene& scene, RendererKind kind) {
  Scene own = scene;
  own.renderer = kind;
  if (kind != RendererKind::gl) own.device = -1;
  Session session(view_of(own, cube()));
  const auto marcher = kind == RendererKind::reference ? open_reference() : open_double();
  const Image image = session.draw(*marcher).image;
  return image.rgba()[4 * (8 * 16 + 8) + 3];
}

TEST(Clip, CutsTheDepthOfAUniformMediumExactly) {
  Scene scene = along_z();
  const auto expect = [&](double length) {
    for (const RendererKind kind : {RendererKind::march_double, RendererKind::reference})
      // float32's rounding of the picture
      EXPECT_NEAR(alpha_of(scene, kind), 1 - std::exp(-0.05 * length), 1e-7);
  };
  expect(32);  // 31 cells, and two whose values fall to 0: half of each counts
  scene.clip = WorldBox{{0, 0, 3.25}, {31, 31, 20.5}};
  expect(17.25);
  scene.clip.reset();
  scene.clip_plane = Plane{{0, 0, 2}, glm::dvec3(0, 0, 11.75)};
  expect(32 - 11.75 - 0.5);
  scene.clip_plane = Plane{{0, 0, -2}, glm::dvec3(0, 0, 11.75)};
  expect(11.75 + 0.5);
  scene.clip_plane = Plane{{0, 0, 1}, glm::dvec3(0, 0, 50)};
  expect(0);
  scene.clip_plane = Plane{{1, 0, 0}, glm::dvec3(17.5, 0, 0)};  // along the ray, which is outside
  expect(0);
}

/// The blobs, cut by a plane and a box.
Scene cut_blobs(int side, Mode mode) {
  Scene scene;
  scene.input = std::string(PSIVOX_ASSETS) + "/blobs.vdb";
  scene.resolution = {side, side};
  scene.clip_plane = Plane{{0.5, -0.7, 0.4}, glm::dvec3(0.1, 0.4, 0.05)};
  scene.clip = WorldBox{{-1, -0.5, -0.6}, {0.8, 1.2, 0.7}};
  scene.mode = mode;
  return scene;
}

TEST(Clip, MarchesAgreeWithTheReferenceInEveryMode) {
  for (const Mode mode :
       {Mode::alpha, Mode::back_to_front, Mode::mip, Mode::isosurface, Mode::xray})
    for (const bool uniform : {false, true}) {
      if (uniform && mode == Mode::isosurface) continue;
      Scene scene = cut_blobs(24, mode);
      scene.early_termination = 0;
      if (uniform)
        scene.step = 1.0 / 32;
      else
        scene.segments = 32;
      const View view = make_view(scene, VolumeFile(scene.input));
      const Image truth = render_reference(view).image;
      expect_content(truth);
      // Steps of 1/32 of a voxel: second order, so a thousandth of the error of whole ones, which
      // is below 1; the maximum between samples differs as much.
      EXPECT_LE(compare_images(double_picture(view), truth).max, 1e-3)
          << parameter_text(scene, "mode") << uniform;
    }
}

using ClipOnGpu = GpuTest;

TEST_F(ClipOnGpu, AgreesWithTheMarchInDouble) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic})
    for (const Mode mode : {Mode::alpha, Mode::back_to_front, Mode::mip, Mode::xray})
      for (const bool uniform : {false, true}) {
        Scene scene = cut_blobs(64, mode);
        scene.projection = projection;
        if (uniform) scene.step = 0.5;
        const View view = make_view(scene, VolumeFile(scene.input));
        const Image gpu = gl_picture(view);
        expect_content(gpu, 0.02, 1);
        // The cut is rounded to 1e-7 of a grid of 64 voxels, and the attenuation of a voxel is
        // below 1 here; the sum of 64 cells is rounded as often.
        EXPECT_LE(difference(parameter_text(scene, "mode"), gpu, double_picture(view)).max, 2e-5);
      }
}

TEST(Clip, WhatIsCutOffIsNotFramed) {
  Scene scene = small_scene(32);
  const View whole = view_of(scene, cube());
  scene.clip = WorldBox{{0, 0, 0}, {7, 7, 7}};
  const View part = view_of(scene, cube());
  EXPECT_LT(glm::length(part.camera.target - glm::dvec3(3.5)), 1);
  EXPECT_LT(part.camera.position.z, 0.6 * whole.camera.position.z);
}

TEST(Slice, ShowsTheInterpolatedValues) {
  const auto ramp = [](const glm::ivec3& v) {
    return static_cast<float>(v.x + 2 * v.y + 3 * v.z) / 64;
  };
  const Field field = make_field({{0, 0, 0}, {15, 15, 15}}, ramp);
  Scene scene = looking(small_scene(16), {7, 7, 50}, {7, 7, 7}, 8.0);
  scene.mode = Mode::slice;
  scene.extinction.reset();
  scene.colormap = Colormap::gray;
  scene.range = glm::dvec2(0, 2);
  set_parameter(scene, "slice", "z=5.5");
  Session session(view_of(scene, field));
  const Image image = session.draw(*open_double()).image;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const double value = ((3.25 + 0.5 * x) + 2 * (10.75 - 0.5 * y) + 3 * 5.5) / 64;
      const std::size_t i = 4 * static_cast<std::size_t>(y * 16 + x);
      // Linear data; the voxels and the picture are float32.
      EXPECT_NEAR(image.rgba()[i], colormap_color(Colormap::gray, value / 2).x, 1e-6);
      EXPECT_EQ(image.rgba()[i + 3], 1);
    }
}

TEST(Slice, HasTheColoursOfALuminanceGrid) {
  const auto colour = [](const glm::ivec3& v) { return glm::vec3(v) / 32.0f; };
  const auto field = share(make_field({{0, 0, 0}, {15, 15, 15}}, [](glm::ivec3) { return 1.0f; }));
  // its voxels are two to the side and half as wide
  Field colours = make_vector_field({{0, 0, 0}, {35, 35, 35}}, colour);
  colours.name = "colours";
  colours.world_from_index =
      glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(-2)), glm::dvec3(0.5));
  Scene scene = looking(small_scene(16), {7, 7, 50}, {7, 7, 7}, 8.0);
  scene.mode = Mode::slice;
  scene.extinction.reset();
  scene.luminance = {2, 1, 1};
  scene.luminance_grid = "colours";
  set_parameter(scene, "slice", "z=5.5");
  Session session(make_view(scene, field, share(std::move(colours))));
  const Image image = session.draw(*open_double()).image;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      const glm::dvec3 at(3.25 + 0.5 * x, 10.75 - 0.5 * y, 5.5);
      const glm::dvec3 expected = glm::dvec3(2, 1, 1) * 2.0 * (at + 2.0) / 32.0;
      const float* pixel = &image.rgba()[4 * static_cast<std::size_t>(y * 16 + x)];
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], expected[c], 1e-6);  // float32
      EXPECT_EQ(pixel[3], 1);
    }
}

TEST(Slice, IsTransparentOutsideAndHasADefault) {
  Scene scene = small_scene(32);
  scene.mode = Mode::slice;
  scene.extinction.reset();
  const View view = view_of(scene, cube());
  ASSERT_TRUE(view.scene.slice && view.scene.slice->point);
  EXPECT_EQ(view.scene.slice->normal, glm::dvec3(0, 0, 1));
  EXPECT_LT(glm::length(*view.scene.slice->point - glm::dvec3(15.5)), 1e-9);
  Session session(view);
  const Image image = session.draw(*open_double()).image;
  EXPECT_EQ(image.rgba()[3], 0);  // the corner
  EXPECT_EQ(image.rgba()[4 * (16 * 32 + 16) + 3], 1);
}

TEST(Slice, EndsAtTheOutermostVoxels) {
  for (const int depth : {15, 0}) {  // a single layer has no inside
    const Field field =
        make_field({{0, 0, 0}, {15, 15, depth}}, [](const glm::ivec3&) { return 1000.0f; });
    Scene scene = looking(small_scene(32), {7.5, 7.5, 50}, {7.5, 7.5, 0}, 20.0);
    scene.mode = Mode::slice;
    scene.extinction.reset();
    scene.colormap = Colormap::gray;
    scene.range = glm::dvec2(900, 1100);
    set_parameter(scene, "slice", "z=" + std::to_string(depth / 2));
    const Image image = Session(view_of(scene, field)).draw(*open_double()).image;
    const double middle = colormap_color(Colormap::gray, 0.5).x;
    int opaque = 0;
    for (std::size_t i = 0; i < image.rgba().size(); i += 4) {
      if (image.rgba()[i + 3] == 0) continue;
      ++opaque;
      EXPECT_NEAR(image.rgba()[i], middle, 1e-6);
    }
    EXPECT_EQ(opaque, 24 * 24) << "pixels of 0.625 voxels, 15 voxels wide";
  }
}

TEST(Slice, IsSeenFaceOn) {
  for (const char* plane : {"x", "y=3", "1,1,0", "0,0,5,-1,2,3"}) {
    Scene scene = small_scene(32);
    scene.mode = Mode::slice;
    scene.extinction.reset();
    set_parameter(scene, "slice", plane);
    const View view = view_of(scene, cube());
    EXPECT_NEAR(std::abs(glm::dot(view.camera.forward, glm::normalize(scene.slice->normal))), 1,
                1e-12)
        << plane;
  }
}

TEST(Planes, AreReadAndWritten) {
  Scene scene;
  set_parameter(scene, "clip-plane", "-x=3");
  EXPECT_EQ(scene.clip_plane, (Plane{{-1, 0, 0}, glm::dvec3(3, 0, 0)}));
  set_parameter(scene, "clip-plane", "1,2,3");
  EXPECT_EQ(scene.clip_plane, (Plane{{1, 2, 3}, {}}));
  set_parameter(scene, "clip-plane", "1,2,3,4,5,6");
  EXPECT_EQ(scene.clip_plane, (Plane{{4, 5, 6}, glm::dvec3(1, 2, 3)}));
  set_parameter(scene, "clip", "0,1,2,3,4,5");
  EXPECT_EQ(to_json(scene_from_json(to_json(scene))), to_json(scene));
  for (const char* bad : {"w=3", "x=", "1,2", "1,2,3,4", "x3", ""})
    EXPECT_THROW(set_parameter(scene, "clip-plane", bad), Error) << bad;
}

}  // namespace
}  // namespace psivox
