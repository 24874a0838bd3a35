#include "draw/regions.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

#include "blobs_scene.h"
#include "psivox/draw.h"
#include "psivox/error.h"

namespace psivox {
namespace {

std::vector<glm::ivec3> some_bricks(int count) {
  std::mt19937 random(7);
  std::vector<glm::ivec3> bricks;
  for (int i = 0; i < count; ++i)
    bricks.emplace_back(int(random() % 40) - 20, int(random() % 30), i);  // distinct
  return bricks;
}

bool holds(const Box& box, const glm::ivec3& brick) {
  return glm::clamp(brick, box.min, box.max) == brick;
}

TEST(Regions, HoldEachBrickOnceAndNoMoreThanAsked) {
  const std::vector<glm::ivec3> bricks = some_bricks(500);
  for (const std::size_t most : {1, 7, 100, 499, 500}) {
    const Regions regions(bricks, most);
    const std::vector<Box> boxes = regions.boxes();
    EXPECT_EQ(boxes.size(), regions.count());
    std::vector<std::size_t> in(boxes.size());
    for (const glm::ivec3& brick : bricks) {
      int found = 0;
      for (std::size_t i = 0; i < boxes.size(); ++i)
        if (holds(boxes[i], brick)) {
          ++found;
          ++in[i];
        }
      EXPECT_EQ(found, 1);
    }
    for (const std::size_t count : in) EXPECT_LE(count, most);
  }
}

TEST(Regions, ComeInTheOrderOfEveryRay) {
  const Regions regions(some_bricks(300), 10);
  std::mt19937 random(3);
  const auto number = [&] { return double(random() % 2001) / 1000 - 1; };
  for (const bool orthographic : {false, true})
    for (int n = 0; n < 50; ++n) {
      Camera camera;
      camera.orthographic = orthographic;
      camera.position = 300.0 * glm::dvec3(number(), number(), number());
      camera.forward = glm::normalize(glm::dvec3(number(), number(), number()));
      const std::vector<Box> boxes = regions.front_to_back(camera, glm::dmat4(1));
      for (int ray = 0; ray < 20; ++ray) {
        const glm::dvec3 way = orthographic
                                   ? camera.forward
                                   : glm::normalize(glm::dvec3(number(), number(), number()));
        const glm::dvec3 from =
            camera.position +
            (orthographic ? 100.0 * glm::dvec3(number(), number(), number()) : glm::dvec3(0));
        double last = -1e300;
        for (const Box& box : boxes) {
          // where the ray enters and leaves the box [8 voxels a brick]
          const glm::dvec3 a = (8.0 * glm::dvec3(box.min) - from) / way;
          const glm::dvec3 b = (8.0 * glm::dvec3(box.max + 1) - from) / way;
          const glm::dvec3 in = glm::min(a, b), out = glm::max(a, b);
          const double begin = std::max({in.x, in.y, in.z, orthographic ? -1e300 : 0.0});
          const double end = std::min({out.x, out.y, out.z});
          if (begin >= end) continue;
          EXPECT_GE(begin, last - 1e-6 * (1 + std::abs(last)));
          last = end;
        }
      }
    }
}

/// Draws whole and in parts, and returns the largest difference of a pixel. The parts' values are
/// read from the file one after another, or at once into memory.
double difference(Scene scene, std::uint64_t limit, bool from_file = true) {
  const auto gpu = open_gpu();
  const Image whole = Session(scene).draw(*gpu).image;
  scene.memory_limit = limit;
  Session session = from_file ? Session(scene) : Session(make_view(scene, VdbFile(scene.input)));
  EXPECT_EQ(session.view().medium.density->reader != nullptr, from_file);
  const Drawn drawn = session.draw(*gpu);
  EXPECT_EQ(drawn.notices.size(), 1u) << "drawn whole";
  return compare_images(whole, drawn.image).max;
}

/// Products of 20 or fewer regions' transmittances in float32, and sums of their radiance.
constexpr double rounding = 1e-6;

TEST(RegionMarcher, DrawsThePictureOfTheWhole) {
  for (const Integrator rule :
       {Integrator::psi_weighted, Integrator::cell_exact, Integrator::porter_duff}) {
    Scene scene = blobs();
    scene.integrator = rule;
    EXPECT_LT(difference(scene, 600000), rounding) << int(rule);
    EXPECT_LT(difference(scene, 900000, /*from_file=*/false), rounding) << int(rule);
  }
}

TEST(RegionMarcher, DrawsFromInsideAndInParallel) {
  Scene scene = blobs();
  scene.camera_position = glm::dvec3(0.1, 0.4, 0.05);
  scene.camera_target = glm::dvec3(1, 0.7, -0.3);
  EXPECT_LT(difference(scene, 600000), rounding);
  scene = blobs();
  scene.projection = Projection::orthographic;
  scene.azimuth = 40;
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST(RegionMarcher, FoldsEachSampleOfAPixel) {
  Scene scene = blobs();
  scene.pixel_samples = 4;
  scene.extinction = 30;  // a product of means would be far from the mean of products
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST(RegionMarcher, DrawsWhatHasOtherGrids) {
  Scene scene = blobs();
  scene.luminance_grid = "color";
  EXPECT_LT(difference(scene, 1600000, false), rounding);
  scene = blobs();
  scene.emission_grid = "temperature";
  scene.emission_scale = 1e-4;  // radiance of about 1
  EXPECT_LT(difference(scene, 1600000, false), rounding);
  scene = blobs();
  scene.transfer_function = std::string(PSIVOX_ASSETS) + "/shells.json";
  EXPECT_LT(difference(scene, 1600000, false), rounding);
}

TEST(RegionMarcher, AddsUpDepthsTowardsTheLight) {
  Scene scene = blobs();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  scene.light_quality = LightQuality::exact;
  EXPECT_LT(difference(scene, 1600000, false), rounding);
  scene.lights.push_back({glm::dvec3(-0.3, -1, 0.5), glm::dvec3(0.2, 0.3, 0.9)});
  EXPECT_LT(difference(scene, 2500000, false), rounding);
}

TEST(RegionMarcher, KeepsATolerance) {
  Scene scene = blobs();
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-4;
  EXPECT_LT(difference(scene, 600000), 1e-3);  // both within it; the largest is some of them
}

TEST(RegionMarcher, SaysWhatItCannotDraw) {
  const auto gpu = open_gpu();
  const auto message = [&](Scene scene, std::uint64_t limit) -> std::string {
    scene.memory_limit = limit;
    try {
      Session(scene).draw(*gpu);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::memory);
      return error.what();
    }
    return "drawn";
  };
  Scene uniform = blobs();
  uniform.sampling = Sampling::uniform;
  EXPECT_NE(message(uniform, 600000).find("only cells"), std::string::npos);
  Scene maximum = blobs();
  maximum.mode = Mode::mip;
  EXPECT_NE(message(maximum, 600000).find("only --mode alpha"), std::string::npos);
  EXPECT_NE(message(blobs(), 1000).find("over the limit"), std::string::npos);
}

}  // namespace
}  // namespace psivox
