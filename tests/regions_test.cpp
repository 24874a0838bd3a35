#include "atlas/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <random>

#include "field/leaf_values.h"
#include "made_fields.h"
#include "march/atlas_march.h"
#include "march_cases.h"
#include "psivox/draw.h"
#include "region_cases.h"

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

/// The pictures of all pixels' rays, R G B A and transmittance in place of A, folded over regions
/// front to back; one region is the whole.
std::vector<glm::dvec4> folded(const View& view, std::size_t parts) {
  const Field& density = *view.medium.density;
  const glm::ivec2 size = view.scene.resolution;
  const RayFold fold(view);
  std::vector<glm::dvec4> rays(std::size_t(size.x * size.y), fold.nothing());
  for (const Region& region : Regions::in_parts(leaf_bricks(density), parts)
                                  .front_to_back(view.camera, density.world_from_index)) {
    const MediumAtlas atlas = parts == 1
                                  ? build_medium_atlas(view)
                                  : build_region_atlas(view, region.bricks, region_ghost(view));
    const MarchSetup setup = make_march_setup(view, atlas);
    glsl::AtlasMarch march(setup, atlas);
    march.sample_offset = glm::dvec2(0.5);
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const glm::ivec2 pixel(x, y);
        const auto collected =
            march.collected(march.march_ray(pixel), march.march_ray_of(march.make_pixel(pixel)));
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

View in_mode(Scene scene, Mode mode, const Field& field) {
  scene.mode = mode;
  if (mode == Mode::isosurface) scene.isovalue = {{0.4}};
  if (mode == Mode::lmip) scene.lmip_threshold = 0.45;
  return view_of(scene, share(field), Glow::density);
}

void expect_one_pass(const View& view, const std::string& what) {
  const auto whole = folded(view, 1);
  EXPECT_GT(largest_difference(whole, std::vector<glm::dvec4>(whole.size())), 0.1) << what;
  for (const std::size_t parts : {3, 64})
    EXPECT_LE(largest_difference(whole, folded(view, parts)), rounding_of_double)
        << what << ", " << parts << " regions";
}

TEST(RegionFold, EqualsOnePassInDouble) {
  for (const Field& field : {mixed(), with_tiles(noise_beside_constant())})
    for (const auto& [name, scene] : cameras())
      for (const auto& [mode_name, mode] : joined_modes)
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

/// Steps that are shorter or longer than a cell, by a rule of the ends, of the middle, and with
/// corrections at the ends.
const Scene uniform_scenes[] = {with(small_scene(21), Integrator::psi_balanced, 0.7),
                                with(small_scene(21), Integrator::midpoint, 1.3),
                                with(small_scene(21), Integrator::psi_weighted, 9.5)};

std::string text_of(const Scene& scene) {
  return info(*scene.integrator).name + std::string(", step ") + std::to_string(*scene.step);
}

TEST(RegionFold, EqualsOnePassOfRaysInAPlane) {
  // Rays in a plane between regions: by their rounded places they are in cells of either side, at
  // the beginning and behind runs, and by the times of faces in one.
  const Scene scene = small_scene(5);
  const std::pair<Scene, Field> cases[] = {
      {looking(scene, {24, -39.58204984664917, -11.785145699977875},
               {24, 20.171283088624477, 23.142945003695786}, 40),
       mixed()},
      {looking(scene, {62.505785776302218, 31.053701462224126, 8},
               {4.8003557613119483, 11.882581017911434, 8}, 40),
       with_tiles(noise_beside_constant())},
      {looking(scene, {-4.5745023526251316, -16.17858967743814, 15.999999999999998},
               {23.397411458194256, 22.83955922909081, 15.999999999999998}, 40),
       with_tiles(noise_beside_constant())}};
  for (const auto& [along, field] : cases)
    expect_one_pass(in_mode(along, Mode::alpha, field), std::to_string(along.camera_position->x));
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

using RegionFoldOnTheGpu = GpuTest;

/// part_marcher_test has the other modes; here rays lie in regions' faces.
TEST_F(RegionFoldOnTheGpu, EqualsOnePass) {
  GlRenderer& gpu = *Gpu::renderer();
  for (const auto& [name, scene] : cameras())
    for (const Scene& way : {scene, with(scene, Integrator::psi_balanced, 0.7)}) {
      const View view = in_mode(way, Mode::alpha, mixed());
      const auto in_parts = [&](std::size_t parts) {
        return in_regions(gpu, Regions::in_parts(leaf_bricks(*view.medium.density), parts))
            .render(view)
            .image;
      };
      // drawn whole, a ray in a face may look up cells beside it: in float32 5e-5 from the exact
      // one
      const bool in_faces = name == "parallel, along faces";
      const Image whole = in_faces ? in_parts(1) : Session(view).draw(gpu).image;
      // a region's picture is rounded to float32, 1e-7 of values about 1, as the whole's is
      EXPECT_LE(compare_images(whole, in_parts(8)).rms, 1e-6) << name;
    }
}

}  // namespace
}  // namespace psivox
