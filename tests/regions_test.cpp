#include "atlas/regions.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "blobs_scene.h"
#include "field_voxels.h"
#include "made_fields.h"
#include "march/atlas_march.h"
#include "march_cases.h"
#include "medium/map_field.h"
#include "psivox/draw.h"
#include "region_cases.h"

namespace psivox {
namespace {

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

// --- levels of detail ----------------------------------------------------------------------------

TEST(CoarseField, KeepsALinearField) {
  const auto linear = [](const glm::dvec3& at) { return at.x - 2 * at.y + 0.5 * at.z + 100; };
  for (const Centering centering : {Centering::node, Centering::cell}) {
    const glm::dvec3 shift(centering == Centering::cell ? 0.5 : 0);
    const Field fine = make_field({{-32, -16, 0}, {31, 31, 31}}, [&](glm::ivec3 v) {
      return float(linear(glm::dvec3(v) + shift));
    });
    const Field coarse = coarse_field(fine, 2, centering);
    EXPECT_EQ(coarse.active_box, (Box{{-8, -4, 0}, {7, 7, 7}}));
    const FieldVoxels values(coarse);
    for (const glm::ivec3 v :
         {glm::ivec3(-8, -4, 0), glm::ivec3(0), glm::ivec3(7), glm::ivec3(-1, 3, 5)}) {
      const glm::dvec3 at(coarse.world_from_index * glm::dvec4(glm::dvec3(v) + shift, 1));
      EXPECT_NEAR(values(v).x, linear(at), 1e-4);  // float32 of values about 100
    }
  }
}

TEST(CoarseField, TakesTilesAndLeavesAlike) {
  const Field leaves = noise_beside_constant();
  const Field from_leaves = coarse_field(leaves, 1, Centering::node);
  const Field from_tiles = coarse_field(with_tiles(leaves), 1, Centering::node);
  const FieldVoxels a(from_leaves), b(from_tiles);
  for_points({{0, 0, 0}, {19, 15, 11}}, [&](const glm::ivec3& v) { EXPECT_EQ(a(v), b(v)); });
}

TEST(CoarseField, HalvesWideTiles) {
  Field field;
  field.active_box = {{-4096, 0, 0}, {-1, 4095, 4095}};
  field.tiles = {{{-4096, 0, 0}, 4096, glm::vec3(3)}};
  const Field coarse = coarse_field(field, 1, Centering::node);
  EXPECT_TRUE(coarse.leaves.empty());
  EXPECT_EQ(coarse.tiles.size(), 16u * 16 * 16);  // of 128 voxels
  const FieldVoxels values(coarse);
  for (const glm::ivec3 v : {glm::ivec3(-2048, 0, 0), glm::ivec3(-1, 2047, 2047)})
    EXPECT_EQ(values(v).x, 3);
  EXPECT_EQ(values({-1, 2048, 0}).x, 0);
}

TEST(CoarseField, OfAnArrayThatEndsHasTheMeansOfItsVoxels) {
  const glm::ivec3 shape(19, 18, 17);
  DenseField made("air", shape, 1, glm::dmat4(1));
  for (int x = 0; x < shape.x; x += 8)
    made.add(std::vector<float>(std::size_t(std::min(8, shape.x - x) * shape.y * shape.z), -1000));
  const VolumeFile file(std::make_shared<const Field>(made.finish()));
  const Field air = file.read("air", {.role = GridRole::data});
  for (const CoarseValue what : {CoarseValue::mean, CoarseValue::sample})
    for (const int times : {1, 2}) {
      const Field coarse = coarse_field(air, times, Centering::node, what);
      EXPECT_EQ(coarse.domain(), (Box{{0, 0, 0}, (shape - 1) >> times}));
      const FieldVoxels values(coarse);
      for_points(coarse.domain(), [&](const glm::ivec3& v) { EXPECT_EQ(values(v).x, -1000); });
    }
}

TEST(CoarseField, DrawsLessAndSaysSo) {
  Scene scene = blobs_scene();
  scene.camera_position = glm::dvec3(2, 1.5, 3);
  scene.camera_target = glm::dvec3(0.3, 0.4, 0);
  const auto picture = [&](int lod, std::uint64_t limit) {
    scene.lod = lod;
    scene.memory_limit = limit;
    Session session(scene);
    const auto& notices = session.view().medium.density->notices;
    const bool said = std::ranges::any_of(
        notices, [](const std::string& line) { return line.find("--lod") != std::string::npos; });
    EXPECT_EQ(said, lod > 0);
    return session.draw(*open_double()).image;
  };
  const Image whole = picture(0, 0), coarse = picture(1, 0);
  const double rms = compare_images(whole, coarse).rms;
  EXPECT_GT(rms, 1e-4);
  EXPECT_LT(rms, 0.05);  // blobs are many voxels wide
  // values that stay in the file are read for it; it is drawn in parts, which rounds to float32
  EXPECT_LT(compare_images(coarse, picture(1, 300000)).max, 1e-6);
}

}  // namespace
}  // namespace psivox
