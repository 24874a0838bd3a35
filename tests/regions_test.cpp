#include "psivox/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>
#include <numeric>
#include <random>

#include "blobs_scene.h"
#include "draw/part_marcher.h"
#include "march/atlas_march.h"
#include "march/carried_light.h"
#include "march/march_double.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/leaf_values.h"
#include "verify/made_fields.h"
#include "verify/made_views.h"

namespace psivox {
namespace {

std::vector<glm::ivec3> some_bricks(int count) {
  std::mt19937 random(7);
  std::vector<glm::ivec3> bricks;
  for (int i = 0; i < count; ++i)
    bricks.emplace_back(int(random() % 40) - 20, int(random() % 30), i);  // distinct
  return bricks;
}

std::vector<Box> boxes_of(const std::vector<Region>& regions) {
  std::vector<Box> boxes;
  for (const Region& region : regions) boxes.push_back(region.bricks);
  return boxes;
}

bool holds(const Box& box, const glm::ivec3& brick) {
  return glm::clamp(brick, box.min, box.max) == brick;
}

TEST(Regions, HoldEachBrickOnceAndNoMoreThanAsked) {
  const std::vector<glm::ivec3> bricks = some_bricks(500);
  for (const std::size_t most : {1, 7, 100, 499, 500}) {
    const Regions regions(bricks, most);
    const std::vector<Box> boxes = boxes_of(regions.all());
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

TEST(Regions, ArePartsOfAboutOneSize) {
  for (const int count : {0, 1, 5, 500})
    for (const std::size_t parts : {1, 2, 3, 7, 8, 64}) {
      const std::vector<glm::ivec3> bricks = some_bricks(count);
      const std::vector<Region> regions = Regions::in_parts(bricks, parts).all();
      ASSERT_EQ(regions.size(), parts);
      std::size_t filled = 0;
      for (std::size_t i = 0; i < parts; ++i) {
        EXPECT_EQ(regions[i].number, i);
        std::size_t held = 0;
        for (const glm::ivec3& brick : bricks) held += holds(regions[i].bricks, brick);
        EXPECT_EQ(held, regions[i].count);
        // these bricks have distinct places along the longest axis, so that each cut rounds by half
        // a brick at most
        EXPECT_LE(regions[i].count, std::size_t(count) / parts + 6) << count << " in " << parts;
        filled += held > 0;
      }
      EXPECT_EQ(filled, std::min(parts, std::size_t(count)));
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
      const std::vector<Box> boxes = boxes_of(regions.front_to_back(camera, glm::dmat4(1)));
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

struct Fold {
  bool reversed = false;  ///< back to front
  bool apron = true;      ///< regions have the voxels around them that they need
  bool ghost = true;      ///< and the bricks that steps reach
};

/// The pictures of all pixels' rays, R G B A and transmittance in place of A, folded over regions
/// front to back; one region is the whole.
std::vector<glm::dvec4> folded(const View& view, std::size_t parts, Fold how = {}) {
  const Field& density = *view.medium.density;
  const glm::ivec2 size = view.scene.resolution;
  const RayFold fold(view);
  std::vector<glm::dvec4> rays(std::size_t(size.x * size.y), fold.nothing());
  std::vector<Region> regions = Regions::in_parts(leaf_bricks(density), parts)
                                    .front_to_back(view.camera, density.world_from_index);
  if (how.reversed) std::reverse(regions.begin(), regions.end());
  for (const Region& region : regions) {
    View part = view;
    const glm::ivec3 most(1 << 20);
    const Box voxels{8 * glm::max(region.bricks.min, -most),
                     8 * glm::min(region.bricks.max, most) + 7};
    if (!how.apron) part.medium.density = share(part_of_field(density, voxels));
    const MediumAtlas atlas =
        parts == 1 ? build_medium_atlas(view)
                   : build_region_atlas(part, region.bricks,
                                        how.ghost ? region_ghost(view) : glm::ivec3(0));
    const MarchSetup setup = make_march_setup(view, atlas);
    glsl::AtlasMarch march(setup, atlas);
    march.sample_offset = glm::dvec2(0.5);
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const glm::ivec2 pixel(x, y);
        const auto collected =
            march.collected(march.march_ray(pixel), march.march_ray_of(march.make_pixel(pixel)),
                            march.make_pixel(pixel));
        fold.add_behind(rays[std::size_t(y * size.x + x)], collected);
      }
  }
  for (glm::dvec4& ray : rays) ray = fold.picture(ray);
  return rays;
}

double largest_difference(const std::vector<glm::dvec4>& a, const std::vector<glm::dvec4>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a[i][c] - b[i][c]));
  return most;
}

/// Cameras that meet regions in different ways. The field is `mixed`, whose planes are at multiples
/// of 8 voxels: its voxels are world units.
std::vector<std::pair<std::string, Scene>> cameras() {
  const Scene scene = small_scene(21);
  const glm::dvec3 middle(12, 12, 12), far(100, 70, -60);
  return {{"outside", looking(scene, far, middle)},
          {"inside", looking(scene, {5.3, 13.1, 9.7}, {30, 20, 14})},
          {"on planes", looking(scene, {8, 16, 8}, {30, 17, 3})},
          {"on a plane, along it", looking(scene, {-60, 8, 16}, {10, 8, 16})},
          {"parallel", looking(scene, far, middle, 70)},
          // 21 pixels of 4 voxels: many rays lie in planes
          {"parallel, along faces", looking(scene, {8, 16, 90}, {8, 16, 0}, 84)}};
}

// A fold of 64 regions multiplies and adds 64 times with a rounding of 1e-16 each. Values are below
// 10, and each ray has the same segments whether whole or in parts.
constexpr double rounding_of_double = 1e-12;

const std::pair<const char*, Mode> modes[] = {{"alpha", Mode::alpha},
                                              {"mip", Mode::mip},
                                              {"lmip", Mode::lmip},
                                              {"isosurface", Mode::isosurface},
                                              {"xray", Mode::xray}};

View in_mode(Scene scene, Mode mode, const Field& field) {
  scene.mode = mode;
  if (mode == Mode::isosurface) scene.isovalue = 0.4;
  if (mode == Mode::lmip) scene.lmip_threshold = 0.45;
  return view_of(scene, share(field), Glow::density);
}

void expect_one_pass(const View& view, const std::string& what) {
  const auto whole = folded(view, 1);
  EXPECT_GT(largest_difference(whole, std::vector<glm::dvec4>(whole.size())), 0.1) << what;
  for (const std::size_t parts : {2, 3, 8, 64})
    EXPECT_LE(largest_difference(whole, folded(view, parts)), rounding_of_double)
        << what << ", " << parts << " regions";
}

TEST(RegionFold, EqualsOnePassInDouble) {
  for (const Field& field : {mixed(), with_tiles(noise_beside_constant())})
    for (const auto& [name, scene] : cameras())
      for (const auto& [mode_name, mode] : modes)
        expect_one_pass(in_mode(scene, mode, field), name + ", " + mode_name);
}

TEST(RegionFold, EqualsOnePassInExactCells) {
  // The number of a cell's nodes follows from the deepest cell, which only one region has.
  Scene scene = looking(small_scene(21), {100, 70, -60}, {12, 12, 12});
  scene.integrator = Integrator::cell_exact;
  scene.extinction = 0.5;
  Field field = make_field({{0, 0, 0}, {30, 30, 30}},
                           [](glm::ivec3 v) { return v == glm::ivec3(29) ? 20.f : noise(v); });
  expect_one_pass(view_of(scene, share(field), Glow::density), "cell-exact");
}

TEST(RegionFold, NeedsTheOrderAndTheApron) {
  const Scene scene = cameras().front().second;
  for (const auto& [name, mode] : modes) {
    const View view = in_mode(scene, mode, mixed());
    const auto whole = folded(view, 1);
    // the greatest value and the integral have no order
    if (mode != Mode::mip && mode != Mode::xray) {
      EXPECT_GT(largest_difference(whole, folded(view, 8, {.reversed = true})), 1e-3) << name;
    }
    EXPECT_GT(largest_difference(whole, folded(view, 8, {.apron = false})), 1e-3) << name;
  }
}

/// Steps that are shorter or longer than a cell, by a rule of the ends, of the middle, and with
/// corrections at the ends.
const Scene uniform_scenes[] = {with(small_scene(21), Integrator::psi_balanced, 0.7),
                                with(small_scene(21), Integrator::midpoint, 1.3),
                                with(small_scene(21), Integrator::psi_weighted, 9.5)};

std::string text_of(const Scene& scene) {
  return info(*scene.integrator).name + std::string(", step ") + std::to_string(*scene.step);
}

TEST(RegionFold, EqualsOnePassInUniformSteps) {
  for (const Scene& steps : uniform_scenes)
    for (const auto& [name, scene] : cameras()) {
      const Scene both = with(scene, *steps.integrator, steps.step);
      const std::string what = text_of(both) + ", " + name;
      expect_one_pass(in_mode(both, Mode::alpha, mixed()), what);
      // of one value: runs, that a step crosses, end at regions' faces
      expect_one_pass(view_of(both, share(with_tiles(noise_beside_constant()))), what + ", runs");
    }
  const Scene steps = uniform_scenes[0];
  for (const Mode mode : {Mode::mip, Mode::lmip, Mode::xray})
    expect_one_pass(in_mode(steps, mode, mixed()), "mode " + std::to_string(int(mode)));
  // where a voxel is longer along one axis than along another, a step is longer in voxels
  expect_one_pass(in_mode(steps, Mode::alpha, mixed(sheared)), "sheared");
}

TEST(RegionFold, NeedsTheGhostOfUniformSteps) {
  for (const Scene& steps : uniform_scenes) {
    const View view = in_mode(steps, Mode::alpha, mixed());
    const auto whole = folded(view, 1);
    EXPECT_GT(largest_difference(whole, folded(view, 8, {.ghost = false})), 1e-3) << text_of(steps);
  }
}

/// Draws a volume region by region.
PartMarcher in_regions(Marcher& marcher, Regions regions) {
  return {marcher, {false, Regions({}, 1), std::move(regions)}, *alone()};
}

/// How a device draws each of the cameras' views in parts and whole.
void expect_one_pass_on(Marcher& gpu, const std::string& what, std::initializer_list<int> counts,
                        const std::function<View(const Scene&)>& view_of_scene) {
  for (const auto& [name, scene] : cameras()) {
    const View view = view_of_scene(scene);
    const auto in_parts = [&](int parts) {
      return in_regions(gpu,
                        Regions::in_parts(leaf_bricks(*view.medium.density), std::size_t(parts)))
          .render(view)
          .image;
    };
    // drawn whole, a ray in a face may look up cells beside it: in float32 5e-5 from the exact one
    const bool in_faces = name == "parallel, along faces";
    const Image whole = in_faces ? in_parts(1) : Session(view).draw(gpu).image;
    // a region's picture is rounded to float32, 1e-7 of values about 1, as the whole's is
    for (const int parts : counts)
      EXPECT_LE(compare_images(whole, in_parts(parts)).rms, 1e-6)
          << what << ", " << name << ", " << parts << " regions";
  }
}

TEST(RegionFold, EqualsOnePassOnTheGpu) {
  const auto gpu = open_gpu();
  for (const auto& [name, mode] : modes) {
    const auto view = [mode = mode](const Scene& scene) { return in_mode(scene, mode, mixed()); };
    if (mode == Mode::alpha)
      expect_one_pass_on(*gpu, name, {1, 2, 3, 8, 64}, view);
    else
      expect_one_pass_on(*gpu, name, {3, 8}, view);
  }
  const Scene steps = uniform_scenes[0];
  expect_one_pass_on(*gpu, text_of(steps), {3, 8}, [&](const Scene& scene) {
    return in_mode(with(scene, *steps.integrator, steps.step), Mode::alpha, mixed());
  });
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

TEST(PartMarcher, DrawsThePictureOfTheWhole) {
  for (const Integrator rule :
       {Integrator::psi_weighted, Integrator::cell_exact, Integrator::porter_duff}) {
    Scene scene = blobs_scene();
    scene.integrator = rule;
    EXPECT_LT(difference(scene, 600000), rounding) << int(rule);
    EXPECT_LT(difference(scene, 900000, /*from_file=*/false), rounding) << int(rule);
  }
}

// A ray that goes on by one cell too far adds up to `least` of that cell's opacity.
TEST(PartMarcher, EndsRaysWhereThoseOfTheWholeEnd) {
  Scene scene = blobs_scene();
  scene.extinction = 30;
  for (const double least : {1e-2, 1.0 / 16384}) {
    scene.early_termination = least;
    EXPECT_LT(difference(scene, 600000), rounding) << least;
  }
}

TEST(PartMarcher, DrawsOtherModes) {
  for (const auto& [name, mode] : modes) {
    if (mode == Mode::alpha) continue;
    Scene scene = blobs_scene();
    scene.mode = mode;
    scene.colormap = Colormap::viridis;  // of the value; joined are values, not colours
    if (mode == Mode::lmip) scene.lmip_threshold = 0.2;
    EXPECT_LT(difference(scene, 700000), rounding) << name;
    EXPECT_LT(difference(scene, 900000, /*from_file=*/false), rounding) << name;
  }
}

TEST(PartMarcher, DrawsInUniformSteps) {
  Scene scene = blobs_scene();
  scene.sampling = Sampling::uniform;
  EXPECT_LT(difference(scene, 900000), rounding);
  EXPECT_LT(difference(scene, 1200000, /*from_file=*/false), rounding);
  scene.emission_grid = "temperature";
  scene.emission_scale = 1e-4;
  scene.step = 2.5;
  EXPECT_LT(difference(scene, 2000000, false), rounding);
}

/// Counts the regions that it draws.
class CountingMarcher final : public DoubleMarcher {
 public:
  void upload(const MediumAtlas& atlas, Filter filter) override {
    ++uploads;
    DoubleMarcher::upload(atlas, filter);
  }
  int uploads = 0;
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

TEST(PartMarcher, DrawsFromInsideAndInParallel) {
  Scene scene = blobs_scene();
  scene.camera_position = glm::dvec3(0.1, 0.4, 0.05);
  scene.camera_target = glm::dvec3(1, 0.7, -0.3);
  EXPECT_LT(difference(scene, 600000), rounding);
  scene = blobs_scene();
  scene.projection = Projection::orthographic;
  scene.azimuth = 40;
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST(PartMarcher, FoldsEachSampleOfAPixel) {
  Scene scene = blobs_scene();
  scene.pixel_samples = 4;
  scene.extinction = 30;  // a product of means would be far from the mean of products
  EXPECT_LT(difference(scene, 600000), rounding);
}

TEST(PartMarcher, DrawsWhatHasOtherGrids) {
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

TEST(PartMarcher, AddsUpDepthsTowardsTheLight) {
  Scene scene = blobs_scene();
  scene.lights = {{glm::dvec3(0.3, -1, -0.5), glm::dvec3(1)}};
  scene.light_quality = LightQuality::exact;
  EXPECT_LT(difference(scene, 2000000, false), rounding);
  scene.lights.push_back({glm::dvec3(-0.3, -1, 0.5), glm::dvec3(0.2, 0.3, 0.9)});
  EXPECT_LT(difference(scene, 3500000, false), rounding);
}

/// Counts the uploads, and the most bricks of one.
class LightCounter final : public DoubleMarcher {
 public:
  void upload(const MediumAtlas& atlas, Filter filter) override {
    ++uploads;
    most = std::max(most, atlas.density.places.size());
    DoubleMarcher::upload(atlas, filter);
  }
  int uploads = 0;
  std::size_t most = 0;
};

// The lattices of lights from all sides, with layers of bricks, and with layers that are boxes
// again: sums of some hundred terms in double. Beams along one axis share the uploads.
TEST(PartMarcher, CarriesLatticesThroughItsLayers) {
  const View view = view_of(small_scene(21), share(mixed()), Glow::density);
  View lit = view;
  lit.medium.light = ScatteredLight{};
  const AtlasOptions options = density_options(lit);
  const std::vector<glm::ivec3> blocks = visible_blocks(*view.medium.density, options);
  const std::vector<glm::ivec3> bricks = textured_bricks(*view.medium.density, options);
  std::vector<std::size_t> all(blocks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
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
        beams, {blocks, all},
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
    LightCounter counter;
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
  const std::vector<glm::ivec3> bricks =
      textured_bricks(*view.medium.density, density_options(view));
  std::vector<std::size_t> all(blocks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto uploads = [&](int directions) {
    std::vector<Beam> beams = sky_beams(glm::dvec3(1), directions);
    for (Beam& beam : beams) beam.method.spacing = 4;
    LightCounter counter;
    in_regions(counter, Regions(bricks, 120))
        .light_depths(view)(beams, {blocks, all}, [](auto, auto, auto) {}, {});
    return counter.uploads;
  };
  EXPECT_GT(uploads(8), 6);
  EXPECT_LE(uploads(64), 2 * uploads(16));  // as memory for their lattices lasts, not 4 times
}

TEST(PartMarcher, KeepsATolerance) {
  Scene scene = blobs_scene();
  scene.sampling.reset();
  scene.early_termination.reset();
  scene.tolerance = 1e-4;
  EXPECT_LT(difference(scene, 600000), 1e-3);  // both within it; the largest is some of them
}

TEST(PartMarcher, SaysWhatItCannotDraw) {
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
  Scene templates = blobs_scene();
  templates.sampling = Sampling::template_;
  templates.projection = Projection::orthographic;
  EXPECT_NE(message(templates, 600000).find("only --sampling cells"), std::string::npos);
  Scene reversed = blobs_scene();
  reversed.mode = Mode::back_to_front;
  EXPECT_NE(message(reversed, 600000).find("only --mode alpha"), std::string::npos);
  EXPECT_NE(message(blobs_scene(), 1000).find("over the limit"), std::string::npos);
}

}  // namespace
}  // namespace psivox
