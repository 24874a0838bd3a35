// Rays that end at the depths of another renderer's picture. A plane's depths must give the picture
// that --clip-plane gives.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <string>

#include "blobs_scene.h"
#include "march_cases.h"
#include "psivox/camera.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

constexpr float infinite = std::numeric_limits<float>::infinity();

/// A plane through the blobs, which the rays of blobs_scene cross from the side of its normal.
const Plane cut{{0.3, -0.2, 0.9}, glm::dvec3(0.1, 0.2, 0.05)};

class HoldoutTest : public GpuTest {
 protected:
  /// Writes depths, by pixels, into a layer of an EXR of the scene's size, and into `another` if it
  /// is named. Returns the file's name.
  std::string written(const Scene& scene, const std::string& channel,
                      const std::function<double(int x, int y)>& depth,
                      const std::string& another = "") const {
    const glm::ivec2 size = scene.resolution;
    Image image = rgba_image(size.x, size.y);
    Layer layer{channel, {channel}, {}};
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) layer.values.push_back(float(depth(x, y)));
    image.layers.push_back(layer);
    if (!another.empty()) image.layers.push_back({another, {another}, layer.values});
    const fs::path path = folder_ / (channel + ".exr");
    write_image(image, path);
    return path.string();
  }

  /// Depths of `cut` through the scene's camera; nothing behind the camera.
  std::string plane(const Scene& scene, DepthKind kind = DepthKind::z) const {
    const Camera camera = Session(scene).view().camera;
    return written(scene, "Z", [&](int x, int y) {
      const WorldRay ray = camera_ray(camera, scene.resolution, x + 0.5, y + 0.5);
      const double t =
          glm::dot(cut.normal, *cut.point - ray.origin) / glm::dot(cut.normal, ray.direction);
      return kind == DepthKind::z ? t * glm::dot(ray.direction, camera.forward) : t;
    });
  }

  /// The scene with a camera that does not depend on what is cut off.
  static Scene framed() {
    Scene scene = blobs_scene();
    keep_camera(scene, Session(scene).view().camera);
    return scene;
  }

  static Image drawn(const Scene& scene) {
    if (scene.renderer == RendererKind::gl) return Session(scene).draw(*Gpu::renderer()).image;
    return Session(scene).draw(*open_marcher(scene)).image;
  }

  static std::string refusal(const Scene& scene) {
    return input_error([&] { drawn(scene); });
  }

  fs::path folder_ = test::empty_scratch_dir();
};

TEST_F(HoldoutTest, APlanesDepthsGiveThePictureOfAClipPlane) {
  for (const Projection projection : {Projection::perspective, Projection::orthographic})
    for (const DepthKind kind : {DepthKind::z, DepthKind::distance})
      for (const Mode mode :
           {Mode::alpha, Mode::back_to_front, Mode::mip, Mode::isosurface, Mode::xray})
        for (const RendererKind renderer :
             {RendererKind::gl, RendererKind::march_double, RendererKind::reference}) {
          // in other modes both projections, each with one kind of depth
          if (mode != Mode::alpha &&
              (kind == DepthKind::z) != (projection == Projection::perspective))
            continue;
          Scene scene = framed();
          scene.projection = projection;
          if (projection == Projection::orthographic) scene.ortho_width = 3;
          scene.mode = mode;
          scene.renderer = renderer;
          if (renderer == RendererKind::reference) scene.sampling.reset();
          SCOPED_TRACE(to_json(scene));
          Scene clipped = scene;
          clipped.clip_plane = cut;
          scene.holdout = plane(scene, kind);
          scene.holdout_depth = kind;
          const Image image = drawn(scene);
          // Both ends are rounded to float32: the file's depth of about 5 to 3e-7, in an
          // attenuation of at most 4.
          EXPECT_LE(compare_images(image, drawn(clipped)).max, 2e-6);
          clipped.clip_plane.reset();
          EXPECT_GT(compare_images(image, drawn(clipped)).max, 0.05);
        }
}

TEST_F(HoldoutTest, WhereNoDepthIsNothingIsHeldOut) {
  Scene scene = framed();
  const Image whole = drawn(scene);
  scene.holdout = written(scene, "depth", [](int x, int) {
    return x % 4 == 0 ? infinite : x % 4 == 1 ? 0 : x % 4 == 2 ? NAN : -1;
  });
  EXPECT_EQ(compare_images(whole, drawn(scene)).max, 0);
  scene.holdout = written(scene, "depth", [](int, int) { return 1e-3; });
  const Image nothing = drawn(scene);
  for (const float value : nothing.rgba()) EXPECT_EQ(value, 0);
}

TEST_F(HoldoutTest, AToleranceHoldsInFrontOfIt) {
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    Scene scene = framed();
    scene.sampling.reset();
    scene.early_termination.reset();
    scene.tolerance = tolerance;
    scene.holdout = plane(scene);
    const Image image = drawn(scene);
    scene.tolerance.reset();
    scene.renderer = RendererKind::reference;
    EXPECT_LE(compare_images(image, drawn(scene)).rms, tolerance);
  }
}

TEST_F(HoldoutTest, PartsEndTheirRaysWhereTheWholeDoes) {
  Scene scene = framed();
  scene.extinction = 30;
  scene.early_termination.reset();
  scene.holdout = plane(scene);
  const Image whole = drawn(scene);
  scene.memory_limit = 600000;
  const Drawn parts = Session(scene).draw(*Gpu::renderer());
  EXPECT_EQ(parts.notices.size(), 1u) << "drawn whole";
  // products of 20 or fewer regions' transmittances in float32
  EXPECT_LE(compare_images(whole, parts.image).max, 1e-6);
}

// All samples of a pixel end in one plane across the view, so that a tilted plane becomes steps.
TEST_F(HoldoutTest, EverySampleOfAPixelEndsAtItsDepth) {
  Scene scene = framed();
  scene.pixel_samples = 5;
  const Camera camera = Session(scene).view().camera;
  const double z = 0.98 * glm::length(camera.target - camera.position);
  Scene clipped = scene;
  clipped.clip_plane = Plane{-camera.forward, camera.position + z * camera.forward};
  scene.holdout = written(scene, "Z", [&](int, int) { return z; });
  EXPECT_LE(compare_images(drawn(scene), drawn(clipped)).max, 2e-6);  // as of one sample
}

TEST_F(HoldoutTest, ItsLayerIsFoundByTheNamesOfRenderers) {
  Scene scene = framed();
  const Image whole = drawn(scene);
  for (const char* name : {"Z", "depth", "depth.Z", "ViewLayer.Depth.Z", "Pz"}) {
    scene.holdout = written(scene, name, [](int, int) { return 1e-3; });
    EXPECT_GT(compare_images(whole, drawn(scene)).max, 0.1) << name;
  }
  scene.holdout = written(scene, "object", [](int, int) { return 1e-3; });
  EXPECT_TRUE(has(refusal(scene), "no channel, or more than one, is called Z or depth"));
  scene.holdout += ":object";
  EXPECT_GT(compare_images(whole, drawn(scene)).max, 0.1);
  scene.holdout += "s";
  EXPECT_TRUE(has(refusal(scene), "no layer 'objects'"));
  const auto near = [](int, int) { return 1e-3; };
  scene.holdout = written(scene, "ViewLayer.Depth.Z", near, "Other.Depth.Z");
  EXPECT_TRUE(has(refusal(scene), "no channel, or more than one, is called Z or depth"));
  scene.holdout = written(scene, "Other.Depth.Z", near, "Z");
  EXPECT_GT(compare_images(whole, drawn(scene)).max, 0.1);
}

TEST_F(HoldoutTest, AnotherSizeIsAnErrorThatNamesBoth) {
  Scene scene = framed();
  scene.holdout = written(scene, "Z", [](int, int) { return 1; });
  scene.resolution = {32, 48};
  const std::string error = refusal(scene);
  EXPECT_TRUE(has(error, "64x48"));
  EXPECT_TRUE(has(error, "32x48"));
}

TEST_F(HoldoutTest, APictureDrawsAgainFromItsMetadata) {
  Scene scene = framed();
  scene.holdout =
      written(scene, "object", [](int x, int) { return x < 32 ? 1e-3 : 0; }) + ":object";
  Image image = drawn(scene);
  add_scene(scene, {}, folder_ / "a.exr", image.metadata);
  write_image(image, folder_ / "a.exr");
  const fs::path moved = folder_ / "moved";
  fs::create_directory(moved);
  for (const char* name : {"a.exr", "object.exr"}) fs::rename(folder_ / name, moved / name);
  const Scene again = read_scene_file((moved / "a.exr").string()).scene;
  EXPECT_EQ(again.holdout, (moved / "object.exr:object").string());
  EXPECT_EQ(compare_images(image, drawn(again)).max, 0);
}

}  // namespace
}  // namespace psivox
