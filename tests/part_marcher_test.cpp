// Volumes drawn region by region, compared with the whole.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "blobs_scene.h"
#include "made_fields.h"
#include "march/carried_light.h"
#include "march/march_double.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "region_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

using InParts = GpuTest;

/// Draws whole and in parts, and returns the largest difference of a pixel. The parts' values are
/// read from the file one after another, or at once into memory.
double difference(Scene scene, std::uint64_t limit, bool from_file = true) {
  const Image whole = Session(scene).draw(*Gpu::renderer()).image;
  scene.memory_limit = limit;
  Session session = from_file ? Session(scene) : Session(make_view(scene, VolumeFile(scene.input)));
  EXPECT_EQ(session.view().medium.density->reader != nullptr, from_file);
  const Drawn drawn = session.draw(*Gpu::renderer());
  EXPECT_EQ(drawn.notices.size(), 1u) << "drawn whole";
  return compare_images(whole, drawn.image).max;
}

/// Products of 20 or fewer regions' transmittances in float32, and sums of their radiance.
constexpr double rounding = 1e-6;

TEST_F(InParts, DrawsThePictureOfTheWhole) {
  for (const Integrator rule :
       {Integrator::psi_weighted, Integrator::cell_exact, Integrator::porter_duff}) {
    Scene scene = blobs_scene();
    scene.integrator = rule;
    EXPECT_LT(difference(scene, 600000), rounding) << int(rule);
    EXPECT_LT(difference(scene, 900000, /*from_file=*/false), rounding) << int(rule);
  }
}

// A ray that goes on by one cell too far adds up to `least` of that cell's opacity.
TEST_F(InParts, EndsRaysWhereThoseOfTheWholeEnd) {
  Scene scene = blobs_scene();
  scene.extinction = 30;
  for (const double least : {1e-2, 1.0 / 16384}) {
    scene.early_termination = least;
    EXPECT_LT(difference(scene, 600000), rounding) << least;
  }
}

TEST_F(InParts, DrawsOtherModes) {
  for (const auto& [name, mode] : joined_modes) {
    if (mode == Mode::alpha) continue;
    Scene scene = blobs_scene();
    scene.mode = mode;
    scene.colormap = Colormap::viridis;  // of the value; joined are values, not colours
    if (mode == Mode::lmip) scene.lmip_threshold = 0.2;
    EXPECT_LT(difference(scene, 700000), rounding) << name;
    EXPECT_LT(difference(scene, 900000, /*from_file=*/false), rounding) << name;
  }
}

TEST_F(InParts, DrawsInUniformSteps) {
  Scene scene = blobs_scene();
  scene.sampling = Sampling::uniform;
  EXPECT_LT(difference(scene, 900000), rounding);
  EXPECT_LT(difference(scene, 1200000, /*from_file=*/false), rounding);
  scene.emission_grid = "temperature";
  scene.emission_scale = 1e-4;
  scene.step = 2.5;
  EXPECT_LT(difference(scene, 2000000, false), rounding);
}

/// Counts the uploads, and the most bricks of one.
class CountingMarcher final : public DoubleMarcher {
 public:
  void upload(const MediumAtlas& atlas, Filter filter) override {
    ++uploads;
    most = std::max(most, atlas.density.places.size());
    DoubleMarcher::upload(atlas, filter);
  }
  int uploads = 0;
  std::size_t most = 0;
};

TEST(PartMarcher, LeavesOutWhatNoRaySees) {
  const auto block = share(make_field({{0, 0, 0}, {39, 39, 39}}, [](glm::ivec3) { return 1.0f; }));
  Scene scene = looking(small_scene(9), {-50, 20, 20}, {20, 20, 20}, /*width=*/25);
  scene.extinction = 30;
  scene.early_termination = 1e-3;
  const auto drawn = [&](Mode mode) {
    scene.mode = mode;
    CountingMarcher marcher;
    in_regions(marcher, Regions::in_parts(leaf_bricks(*block), 8)).render(view_of(scene, block));
    return marcher.uploads;
  };
  EXPECT_EQ(drawn(Mode::alpha), 4);
  EXPECT_EQ(drawn(Mode::isosurface), 4);
  EXPECT_EQ(drawn(Mode::mip), 8);
  EXPECT_EQ(drawn(Mode::xray), 8);
}

// Behind the first maximum, 5e-5, values fall by more than what tells a fall from a plateau, but by
// less within either part; a greater maximum follows.
TEST(PartMarcher, ALocalMaximumMayFallOverSeveralParts) {
  const auto field = share(make_field({{0, 0, 0}, {15, 7, 7}}, [](glm::ivec3 v) {
    if (v.x == 13) return 1.0f;
    return v.x < 5 ? 1e-5f * float(v.x) : 5e-5f - 8e-7f * float(v.x - 5);
  }));
  Scene scene = looking(small_scene(3), {-50, 3.5, 3.5}, {8, 3.5, 3.5}, /*width=*/4);
  scene.mode = Mode::lmip;
  const View view = view_of(scene, field);
  const auto value = [&](std::size_t parts) {
    DoubleMarcher marcher;
    const Image image =
        in_regions(marcher, Regions::in_parts(leaf_bricks(*field), parts)).render(view).image;
    return image.rgba()[4 * 4];  // of the middle pixel
  };
  const float whole = value(1), least = 4e-6f;
  EXPECT_GT(view.medium.least_value, 0.9 * double(least));
  EXPECT_NEAR(whole, 5e-5f, least);
  for (const std::size_t parts : {2, 4, 8}) EXPECT_EQ(value(parts), whole) << parts;
}

TEST_F(InParts, DrawsFromInsideAndInParallel) {
  Scene scene = blobs_scene();
  scene.camera_position = glm::dvec3(0.1, 0.4, 0.05);
  scene.camera_target = glm::dvec3(1, 0.7, -0.3);
  EXPECT_LT(difference(scene, 600000), rounding);
  scene = blobs_scene();
  scene.projection = Projection::orthographic;
  scene.azimuth = 40;
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST_F(InParts, FoldsEachSampleOfAPixel) {
  Scene scene = blobs_scene();
  scene.pixel_samples = 4;
  scene.extinction = 30;  // a product of means would be far from the mean of products
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST_F(InParts, DrawsWhatHasOtherGrids) {
  Scene scene = blobs_scene();
  scene.luminance_grid = "color";
  EXPECT_LT(difference(scene, 1600000, false), rounding);
  scene = blobs_scene();
  scene.emission_grid = "temperature";
  scene.emission_scale = 1e-4;  // radiance of about 1
  EXPECT_LT(difference(scene, 1600000, false), rounding);
  scene = blobs_scene();
  scene.transfer_function = std::string(PSIVOX_ASSETS) + "/shells.json";
  EXPECT_LT(difference(scene, 1600000, false), rounding);
}

TEST_F(InParts, AddsUpDepthsTowardsTheLight) {
  Scene scene = blobs_scene();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  scene.light_quality = LightQuality::exact;
  EXPECT_LT(difference(scene, 2000000, false), rounding);
  scene.lights.push_back({glm::dvec3(-0.3, -1, 0.5), glm::dvec3(0.2, 0.3, 0.9)});
  EXPECT_LT(difference(scene, 3500000, false), rounding);
}

// The lattices of lights from all sides, with layers of bricks, and with layers that are boxes
// again: sums of some hundred terms in double. Beams along one axis share the uploads.
TEST(PartMarcher, CarriesLatticesThroughItsLayers) {
  const View view = view_of(small_scene(21), share(mixed()), Glow::density);
  View lit = view;
  lit.medium.light = ScatteredLight{};
  const AtlasOptions options = density_options(lit);
  const std::vector<glm::ivec3> blocks = visible_blocks(*view.medium.density, options);
  std::vector<glm::ivec3> bricks;
  predict_atlas(*view.medium.density, options, &bricks);
  std::vector<Beam> beams;
  for (const glm::dvec3& way :
       {glm::dvec3(0, 0, 1), glm::dvec3(-0.3, -1, 0.2), glm::dvec3(0.6, 0.1, -0.8),
        glm::dvec3(1, 0.4, 0.9), glm::dvec3(-1, 0.9, 0.4), glm::dvec3(0.2, 1, -0.7),
        glm::dvec3(0.1, -1, 0.8)})
    for (const double spacing : {2.0, 0.5})
      beams.push_back({glm::normalize(way), glm::dvec3(1), {.spacing = spacing}});
  const auto depths_by = [&](auto& marcher) {
    std::vector<std::vector<double>> found(beams.size(),
                                           std::vector<double>(512 * blocks.size(), -1));
    marcher.light_depths(lit)(
        beams, blocks,
        [&](std::size_t beam, std::size_t block, std::span<const double> own) {
          std::ranges::copy(own, found[beam].begin() + std::ptrdiff_t(512 * block));
        },
        {});
    return found;
  };
  DoubleMarcher whole;
  const MediumAtlas atlas = build_medium_atlas(lit);
  whole.upload(atlas, Filter::exact);
  const auto truth = depths_by(whole);
  for (const std::size_t most : {bricks.size() / 2, bricks.size() / 9, bricks.size() / 40}) {
    CountingMarcher counter;
    PartMarcher parts = in_regions(counter, Regions(bricks, most));
    const auto sums = depths_by(parts);
    double off = 0;
    for (std::size_t b = 0; b < beams.size(); ++b)
      for (std::size_t i = 0; i < sums[b].size(); ++i)
        off = std::max(off, std::abs(sums[b][i] - truth[b][i]));
    EXPECT_LE(off, 1e-12) << most;
    // a row of bricks is not split, and along the light it has the bricks beside it
    EXPECT_LE(counter.most, std::max<std::size_t>(most, 2 * 8)) << most;
    std::printf("  %zu of %zu bricks: %d uploads\n", most, bricks.size(), counter.uploads);
  }
}

TEST(PartMarcher, GathersASkyInOnePassForEachSide) {
  const View view = view_of(small_scene(21), share(mixed()), Glow::density);
  const std::vector<glm::ivec3> blocks =
      visible_blocks(*view.medium.density, density_options(view));
  std::vector<glm::ivec3> bricks;
  predict_atlas(*view.medium.density, density_options(view), &bricks);
  const auto uploads = [&](int directions) {
    std::vector<Beam> beams = sky_beams(glm::dvec3(1), directions);
    for (Beam& beam : beams) beam.method.spacing = 4;
    CountingMarcher counter;
    in_regions(counter, Regions(bricks, 120))
        .light_depths(view)(beams, blocks, [](auto, auto, auto) {}, {});
    return counter.uploads;
  };
  EXPECT_GT(uploads(8), 6);
  EXPECT_LE(uploads(64), 2 * uploads(16));  // as memory for their lattices lasts, not 4 times
}

TEST_F(InParts, KeepsATolerance) {
  Scene scene = blobs_scene();
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-4;
  EXPECT_LT(difference(scene, 600000), 1e-3);  // both within it; the largest is some of them
}

TEST_F(InParts, SaysWhatItCannotDraw) {
  const auto message = [&](Scene scene, std::uint64_t limit) {
    scene.memory_limit = limit;
    return error_of(ExitCode::memory, [&] { Session(scene).draw(*Gpu::renderer()); });
  };
  Scene templates = blobs_scene();
  templates.sampling = Sampling::template_;
  templates.projection = Projection::orthographic;
  EXPECT_TRUE(has(message(templates, 600000), "only --sampling cells"));
  Scene reversed = blobs_scene();
  reversed.mode = Mode::back_to_front;
  EXPECT_TRUE(has(message(reversed, 600000), "only --mode alpha"));
  EXPECT_TRUE(has(message(blobs_scene(), 1000), "over the limit"));
}

}  // namespace
}  // namespace psivox
