// Several volumes in one scene: against one volume that holds their sum, the reference, each other
// in another order, and tolerances.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/text_file.h"
#include "field/leaf_values.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/medium.h"
#include "psivox/open.h"
#include "psivox/vdb.h"
#include "scratch.h"
#include "thrown.h"

namespace psivox {
namespace {

const std::string assets = std::string(PSIVOX_ASSETS) + "/";

Scene scene_with(std::vector<std::string> volumes) {
  Scene scene;
  scene.input = assets + "rotated.vdb";
  scene.look = "plain";
  scene.volumes = std::move(volumes);
  scene.extinction = 4;
  scene.luminance = glm::dvec3(0.9, 0.8, 0.7);
  scene.resolution = {64, 48};
  return scene;
}

/// A slab and blobs of other colours, on lattices that are turned against the first one's.
std::vector<std::string> slab_and_blobs() {
  return {assets + "slab.vdb extinction=2 luminance=1,0.3,0.1 translate=-1.2,-0.5,-0.2 scale=0.9",
          assets + "blobs.vdb extinction=3 luminance=0.2,0.5,1 rotate=20,40,10 scale=0.5"};
}

Image drawn(const Scene& scene, Marcher& marcher) { return Session(scene).draw(marcher).image; }

using VolumesOnTheGpu = GpuTest;

/// Within rounding of float32 texels and sums: the same bound as one volume has in march_test.
constexpr double rounding = 2e-6;

TEST_F(VolumesOnTheGpu, TwoOnOneLatticeAreTheirSum) {
  Scene whole = scene_with({});
  whole.tolerance = 1e-6;
  whole.texel = TexelType::float32;  // codes take what the tolerance leaves
  whole.extinction = 6;
  Scene parts = whole;
  parts.volumes = {whole.input + " extinction=4"};
  parts.extinction = 2;
  EXPECT_LE(compare_images(drawn(whole, *Gpu::renderer()), drawn(parts, *Gpu::renderer())).max,
            1e-6);
  whole.lights = parts.lights = {{glm::dvec3(1, -1, -0.5)}};
  whole.luminance = parts.luminance = glm::dvec3(0.1);
  EXPECT_LE(compare_images(drawn(whole, *Gpu::renderer()), drawn(parts, *Gpu::renderer())).max,
            rounding);
}

TEST_F(VolumesOnTheGpu, AgreeWithTheReferenceOnLatticesOfTheirOwn) {
  Scene scene = scene_with(slab_and_blobs());
  scene.texel = TexelType::float32;
  scene.early_termination = 0;
  for (const Classification how : {Classification::post, Classification::nearest}) {
    scene.classification = how;  // of the first
    const Image reference = drawn(scene, *open_reference());
    EXPECT_LE(compare_images(drawn(scene, *open_double()), reference).max,
              3e-7);  // texels are float32
    EXPECT_LE(compare_images(drawn(scene, *Gpu::renderer()), reference).rms, 2e-7);
  }
}

TEST_F(VolumesOnTheGpu, AreSeenUpToTheFacesThatEndBoth) {
  Scene scene = scene_with({assets + "slab.vdb extinction=2"});
  scene.input = assets + "slab.vdb";
  scene.texel = TexelType::float32;
  scene.early_termination = 0;
  scene.classification =
      Classification::nearest;  // the first one's rays run half a voxel beside it
  const Image reference = drawn(scene, *open_reference());
  EXPECT_LE(compare_images(drawn(scene, *open_double()), reference).max, 3e-7);
  EXPECT_LE(compare_images(drawn(scene, *Gpu::renderer()), reference).rms, rounding);
}

TEST_F(VolumesOnTheGpu, AreVacuumWhereOneHasNoData) {
  std::string ball =
      "NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: raw\nendian: little\n\n";
  for (int i = 0; i < 12 * 12 * 12; ++i) {
    const glm::dvec3 p = glm::dvec3(i % 12, i / 12 % 12, i / 144) / 5.5 - 1.0;
    const float value = glm::dot(p, p) < 0.8 ? float(1 - 0.5 * glm::length(p)) : std::nanf("");
    ball.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const std::string path = (test::scratch_dir() / "ball.nrrd").string();
  write_text(path, ball);
  Scene scene =
      scene_with({path + " extinction=2 luminance=1,0.3,0.1 scale=0.1 translate=-1,-1,0"});
  scene.texel = TexelType::float32;
  scene.early_termination = 0;
  const Image reference = drawn(scene, *open_reference());
  EXPECT_LE(difference("double", drawn(scene, *open_double()), reference).max, 3e-7);
  EXPECT_LE(difference("GPU", drawn(scene, *Gpu::renderer()), reference).rms, 2e-7);
}

TEST_F(VolumesOnTheGpu, AgreeWhereAFloatHasNoDigitsForTheFirstOnesVoxels) {
  // 10^4 voxels of the first one away, places are rounded by more than two faces are taken apart
  Scene scene = scene_with(
      {assets + "blobs.vdb extinction=0.02 luminance=0.2,0.5,1 rotate=20,40,10 scale=300"});
  scene.resolution = {32, 24};
  scene.texel = TexelType::float32;
  scene.early_termination = 0;
  EXPECT_LE(compare_images(drawn(scene, *Gpu::renderer()), drawn(scene, *open_reference())).max,
            rounding);
}

TEST_F(VolumesOnTheGpu, OneThatAttenuatesNothingTakesNoLight) {
  Scene scene = scene_with({});
  scene.lights = {{glm::dvec3(1, -1, -0.5)}};
  scene.camera_position = glm::dvec3(1, 2, 4);
  scene.camera_target = glm::dvec3(0);
  constexpr double E = 1e-4;
  scene.tolerance = E;
  Scene beside = scene;
  beside.volumes = {assets + "blobs.vdb extinction=0 translate=0.2,0,0"};
  // each is within the tolerance of the truth
  EXPECT_LE(compare_images(drawn(beside, *Gpu::renderer()), drawn(scene, *Gpu::renderer())).rms,
            2 * E);
}

TEST(Volumes, DoNotDependOnTheirOrder) {
  Scene scene = scene_with(slab_and_blobs());
  scene.early_termination = 0;
  Scene other = scene;
  std::swap(other.volumes[0], other.volumes[1]);
  const View view = Session(scene).view();
  other.camera_position = scene.camera_position = view.camera.position;
  other.camera_target = scene.camera_target = view.camera.position + 2.0 * view.camera.forward;
  EXPECT_LE(compare_images(drawn(scene, *open_double()), drawn(other, *open_double())).max, 1e-9);
}

TEST(Volumes, EmissionsAddUp) {
  Scene scene = scene_with({});
  scene.input = assets + "blobs.vdb";
  scene.grid = "density";
  scene.emission_grid = "temperature";
  scene.emission_scale = 3e-4;
  scene.texel = TexelType::float32;
  scene.early_termination = 0;
  Scene parts = scene;  // the same, with half of the emission in a volume of its own
  parts.emission_scale = 1e-4;
  parts.extinction = 3;
  parts.volumes = {scene.input + " extinction=1 emission-grid=temperature emission-scale=0.0002"};
  scene.integrator = Integrator::cell_exact;
  const auto march = open_double();
  const Image whole = drawn(scene, *march);
  const auto values = whole.rgba();
  const double brightest = double(*std::ranges::max_element(values));
  EXPECT_LE(compare_images(whole, drawn(parts, *march)).max, rounding * std::max(brightest, 1.0));
  EXPECT_GT(brightest, 0.2);
}

/// Without light, under two lights, and with all else that a volume may have.
Scene lit_scene(int number) {
  Scene scene = scene_with(slab_and_blobs());
  if (number == 1) scene.lights = {{glm::dvec3(1, -0.6, -0.4)}, {glm::dvec3(0, -1, 0)}};
  if (number == 2) {
    scene.lights = {{glm::dvec3(1, -0.6, -0.4)}};
    scene.phase_g = 0.5;
    scene.volumes[1] += " albedo=0.9,0.5,0.2 emission-grid=temperature emission-scale=0.002";
  }
  if (number > 0) scene.luminance = glm::dvec3(0.02);
  return scene;
}

class VolumeTolerance : public GpuTest, public testing::WithParamInterface<int> {};

TEST_P(VolumeTolerance, IsKept) {
  Scene scene = lit_scene(GetParam());
  scene.light_quality = LightQuality::automatic;
  Scene exact = scene;
  exact.renderer = RendererKind::reference;
  const Image truth = drawn(exact, *open_reference());
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    if (!scene.lights.empty() && tolerance != 1e-3) continue;  // it is exact in further volumes
    scene.tolerance = tolerance;
    EXPECT_LE(compare_images(drawn(scene, *Gpu::renderer()), truth).rms, tolerance) << tolerance;
  }
}

TEST_F(VolumesOnTheGpu, ALampShinesThroughTheCodesOfAFog) {
  Scene scene =
      scene_with({assets + "single_voxel.vdb extinction=200 scale=0.06 translate=-0.2,0.15,-1"});
  scene.input = assets + "blobs.vdb";
  scene.extinction = 0.3;
  scene.resolution = {128, 128};
  for (const char* luminance : {" luminance=1e3,1e3,1e4", " luminance=1e4,1e3,1e4"}) {
    Scene lamp = scene;
    lamp.volumes[0] += luminance;
    const Image truth = drawn(lamp, *open_reference());
    lamp.tolerance = 1e-3;
    EXPECT_LE(compare_images(drawn(lamp, *Gpu::renderer()), truth).rms, 1e-3) << luminance;
  }
}

TEST_F(VolumesOnTheGpu, ALampThatNoPilotRayMeetsCountsInTheEstimate) {
  Scene scene =
      scene_with({assets + "single_voxel.vdb extinction=63.6 scale=0.0408 luminance=267,827,17800 "
                           "translate=0.26,0.9,-0.93"});
  scene.extinction = 7.42;
  scene.azimuth = 177;
  scene.elevation = 25;
  scene.resolution = {48, 48};
  const Image truth = drawn(scene, *open_reference());
  scene.tolerance = 1e-4;
  const Drawn picture = Session(scene).draw(*Gpu::renderer());
  // float32 holds no more of two pixels of 2000 and 8000
  EXPECT_GE(picture.plan->chosen.rms, compare_images(picture.image, truth).rms / 2);
}

/// Layer `bound`, against the march in double, which shares no code with the reference.
TEST_F(VolumesOnTheGpu, AreBoundedInEveryPixel) {
  Scene scene = lit_scene(2);
  scene.resolution = {32, 24};
  scene.clip = {glm::dvec3(-0.7, -9, -9), glm::dvec3(9)};
  Scene exact = scene;
  exact.light_quality = LightQuality::exact;
  exact.early_termination = 0;
  exact.texel = TexelType::float32;
  const Image truth = drawn(exact, *open_double());
  scene.early_termination = 0.4;
  Wish wish;
  wish.layers.bound = true;
  const Image picture = Session(scene).draw(*Gpu::renderer(), wish).image;
  const std::vector<float>& bound = picture.layers.back().values;
  std::size_t telling = 0;  // pixels that are off by more than the truth
  for (std::size_t i = 0; i < bound.size(); ++i) {
    double off = 0;
    for (std::size_t c = 0; c < 4; ++c)
      off = std::max(off, std::abs(double(picture.rgba()[4 * i + c]) - truth.rgba()[4 * i + c]));
    EXPECT_LE(off, bound[i] + rounding) << i;  // of the truth: voxels and light in float32
    telling += off > 50 * rounding;
    if (off > 50 * rounding) {
      EXPECT_LE(bound[i], 1.05 * off) << i;
    }
  }
  EXPECT_GT(telling, 100u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, VolumeTolerance, testing::Values(0, 1, 2));

TEST(Volumes, AreCompletedSoThatTheyDrawTheSameAgain) {
  Scene scene = scene_with({assets + "slab.vdb"});
  scene.extinction.reset();
  const Scene resolved = Session(scene).view().scene;
  ASSERT_EQ(resolved.volumes.size(), 1u);
  EXPECT_TRUE(has(resolved.volumes[0], " extinction="));
  const auto march = open_double();
  EXPECT_EQ(compare_images(drawn(scene, *march), drawn(resolved, *march)).max, 0);
}

TEST(Volumes, HaveTheLooksOfTheirFiles) {
  Scene scene = scene_with({assets + "blobs.vdb"});
  scene.look.clear();
  scene.luminance.reset();
  const OpenedScene opened = open_scene(scene, VolumeFile(scene.input), {.open_look = "auto"});
  EXPECT_TRUE(has(opened.view.scene.volumes[0], "emission-grid=temperature"));
}

TEST(Volumes, RefuseWhatTheyCannotDraw) {
  const auto refused = [](auto change) {
    Scene scene = scene_with({assets + "slab.vdb"});
    change(scene);
    return usage_error([&] { Session session(scene); });
  };
  EXPECT_TRUE(has(refused([](Scene& s) { s.mode = Mode::mip; }), "--mode alpha"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.step = 1; }), "--step"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.colormap = Colormap::viridis; }), "--colormap"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.volumes[0] += " zoom=2"; }), "'zoom'"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.volumes[0] += " extinction=x"; }), "extinction"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.extinction = 0; }), "above 0"));
  EXPECT_TRUE(has(refused([](Scene& s) { s.volumes.assign(8, s.volumes[0]); }), "7"));
}

}  // namespace
}  // namespace psivox
