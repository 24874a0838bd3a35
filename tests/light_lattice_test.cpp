// Light from a lattice that is sheared along it, against exact light.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>
#include <vector>

#include "atlas/regions.h"
#include "light_cases.h"
#include "march/light.h"
#include "march/light_lattice.h"
#include "march_cases.h"
#include "scratch.h"

namespace psivox {
namespace {

/// A view's exact light in double, and what lattices miss of it.
class ExactLight {
 public:
  explicit ExactLight(View view)
      : view_(std::move(view)),
        atlas_(build_medium_atlas(view_)),
        blocks_(blocks_of(view_)),
        depths_(depths_of(view_, march_double_light_depths(view_, atlas_), blocks_)) {}

  Difference from_lattice(double spacing) const {
    return difference_of(
        view_, blocks_,
        depths_of(view_, march_double_light_depths(view_, atlas_), blocks_, {.spacing = spacing}),
        depths_);
  }

 private:
  View view_;
  MediumAtlas atlas_;
  std::vector<glm::ivec3> blocks_;
  std::vector<double> depths_;
};

std::string lattice_function_file(const std::string& name, const std::string& text) {
  return test::write_bytes(name + ".json", text).string();
}

/// A function that attenuates everywhere, and falls.
std::string lattice_function_file() {
  return lattice_function_file("function", R"({"points": [
    {"value": 0, "attenuation": 0.015625, "color": [1, 1, 1]},
    {"value": 0.3, "attenuation": 0.4, "color": [1, 0.5, 0.25]},
    {"value": 0.6, "attenuation": 0.1, "color": [0, 1, 1]}]})");
}

/// One that bricks of small values are left out for, which rises alone.
std::string clear_function_file() {
  return lattice_function_file("clear", R"({"points": [
    {"value": 0.2, "attenuation": 0}, {"value": 0.5, "attenuation": 0.1},
    {"value": 0.8, "attenuation": 0.6}]})");
}

/// A table over gradients.
std::string gradient_function_file() {
  return lattice_function_file("gradient", R"({"gradients": [0, 0.1, 0.4], "points": [
    {"value": 0, "attenuation": [0, 0, 0.2]}, {"value": 0.4, "attenuation": [0.1, 0.5, 0.3]},
    {"value": 0.7, "attenuation": [0.2, 0.1, 0.6]}]})");
}

const glm::dvec3 oblique[] = {{-0.3, -1, 0.2}, {0.6, 0.1, -0.8}, {0.01, 1, 0.03}};

TEST(LightLattice, IsExactWhereColumnsPassThroughVoxels) {
  // Along an axis a column stays on an edge of cells, on a diagonal it goes from corner to corner:
  // Simpson's rule is exact for a cell's cubic. What is left are sums of some hundred terms in
  // double.
  for (const glm::dvec3& direction :
       {glm::dvec3(0, 0, -1), glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 1),
        glm::dvec3(-1, 1, -1), glm::dvec3(0, 1, -1)}) {
    const ExactLight exact(view_of(lit_scene(direction), mixed()));
    for (const double spacing : {1.0, 0.5})
      EXPECT_LE(exact.from_lattice(spacing).max, 1e-12)
          << direction.x << ' ' << direction.y << ' ' << direction.z;
  }
}

TEST(LightLattice, ConvergesToExactLight) {
  const glm::dmat4 turned =
      glm::scale(glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, 2, 3)), glm::dvec3(1, 0.5, 2));
  for (const std::string& function :
       {std::string(), lattice_function_file(), clear_function_file()})
    for (const glm::dvec3& direction : oblique) {
      if (!function.empty() && direction != oblique[0]) continue;
      Scene scene = lit_scene(direction);
      scene.extinction = 0.05;
      scene.transfer_function = function;
      Field field = mixed();
      field.world_from_index = turned;
      const ExactLight exact(view_of(scene, field));
      // from a spacing of a voxel on: the values are noise, which a wider one knows nothing of
      double before = exact.from_lattice(1).rms;
      for (const double spacing : {0.5, 0.25}) {
        const Difference d = exact.from_lattice(spacing);
        std::printf("  light %g,%g,%g%s spacing %g: rms %.2e, max %.2e\n", direction.x, direction.y,
                    direction.z, function.empty() ? "" : ", function", spacing, d.rms, d.max);
        // first order at the least, since attenuation has kinks at the faces of cells: a half, and
        // a fifth of that for terms of higher order
        EXPECT_LE(d.rms, 0.6 * before);
        before = d.rms;
      }
    }
}

TEST(LightLattice, WantedBlocksAreThoseOfAll) {
  for (const glm::dvec3& direction : oblique) {
    const View view = view_of(lit_scene(direction), mixed());
    const std::vector<glm::ivec3> blocks = blocks_of(view);
    const MediumAtlas atlas = build_medium_atlas(view);
    const LightDepths depths = march_double_light_depths(view, atlas);
    const LightMethod method{.spacing = 0.5};
    const std::vector<double> all = depths_of(view, depths, blocks, method);
    for (std::size_t first : {std::size_t{0}, blocks.size() / 2, blocks.size() - 1}) {
      const std::vector<double> own =
          depths_of(view, depths, std::span(blocks).subspan(first, 1), method);
      EXPECT_TRUE(std::equal(own.begin(), own.end(), all.begin() + std::ptrdiff_t(512 * first)));
    }
  }
}

TEST(LightLattice, ColumnsEndAtTheDomain) {
  // One attenuation, 1/64, everywhere: the depth is the length to the upper face, where the light
  // comes in. Left out are voxels that the light reaches by another face, or whose columns lie
  // beyond one.
  Scene scene = lit_scene({0.3, 0.1, -1});
  scene.transfer_function = lattice_function_file();
  scene.extinction = 1;
  const View view =
      view_of(scene, make_field({{0, 0, 0}, {20, 20, 20}}, [](glm::ivec3) { return 0.f; }));
  const MediumAtlas atlas = build_medium_atlas(view);
  const std::vector<glm::ivec3> blocks = blocks_of(view);
  const std::vector<double> depths =
      depths_of(view, march_double_light_depths(view, atlas), blocks, {.spacing = 1});
  const double slant = std::sqrt(1 + 0.3 * 0.3 + 0.1 * 0.1);
  int seen = 0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const int n = int(i % 512);
    const glm::ivec3 at = blocks[i / 512] + glm::ivec3(n >> 6, (n >> 3) & 7, n & 7);
    if (at.x < 11 || at.x > 18 || at.y < 6 || at.y > 18 || at.z < 0 || at.z > 20) continue;
    EXPECT_NEAR(depths[i], slant / 64 * (21 - at.z), 1e-13) << at.x << ' ' << at.y << ' ' << at.z;
    ++seen;
  }
  EXPECT_EQ(seen, 8 * 13 * 21);
}

TEST(LightLattice, ColumnsThatCrossFacesAreThoseInside) {
  // A far voxel on either side moves the domain's faces away. The shear is such that columns stay
  // where they were, and what the voxels hide is far below rounding.
  const auto value = [](const glm::ivec3& v) {
    const bool far = v == glm::ivec3(-40) || v == glm::ivec3(63);
    const bool rim =
        glm::any(glm::lessThan(v, glm::ivec3(2))) || glm::any(glm::greaterThan(v, glm::ivec3(28)));
    return far ? 1e-20f : rim ? 0.0f : noise(v);
  };
  const Scene scene = lit_scene({0.5, 0.25, -1});
  const View small = view_of(scene, make_field({{0, 0, 0}, {31, 31, 31}}, value)),
             large = view_of(scene, make_field({{-40, -40, -40}, {63, 63, 63}}, value));
  const std::vector<glm::ivec3> blocks = blocks_of(small);
  const auto depths = [&](const View& view) {
    const MediumAtlas atlas = build_medium_atlas(view);
    return depths_of(view, march_double_light_depths(view, atlas), blocks, {.spacing = 1});
  };
  const std::vector<double> near = depths(small), far = depths(large);
  double most = 0;
  for (std::size_t i = 0; i < near.size(); ++i) most = std::max(most, std::abs(near[i] - far[i]));
  EXPECT_LE(most, 1e-12);  // sums of some hundred terms in double
  EXPECT_GT(*std::ranges::max_element(near), 1);
}

TEST(LightLattice, ColumnsEndInTheDark) {
  Scene scene = lit_scene(oblique[0]);
  scene.extinction = 5;
  const View view = view_of(scene, mixed());
  const MediumAtlas atlas = build_medium_atlas(view);
  const std::vector<glm::ivec3> blocks = blocks_of(view);
  std::size_t bricks = 0;
  const LightDepths depths = one_by_one(
      [&](const Beam& beam, LightBlocks asked, const TakeDepths& take, const Progress& progress) {
        const LatticeFrame frame(view, atlas.density.domain, beam);
        const LatticeColumns columns = light_columns<double>(frame, view, atlas, beam);
        const auto counted = [&](std::span<const LatticeBrick> some, std::span<double> to) {
          bricks += some.size();
          columns(some, to);
        };
        lattice_depths(frame, atlas, asked, counted, take, progress);
      });
  const std::vector<double> all = depths_of(view, depths, blocks, {.spacing = 0.5});
  const std::size_t bricks_of_all = std::exchange(bricks, 0);
  const double end = 8;
  const std::vector<double> ended =
      depths_of(view, depths, blocks, {.spacing = 0.5, .termination = std::exp(-end)});
  EXPECT_LE(bricks, 0.75 * double(bricks_of_all));
  EXPECT_GT(*std::ranges::max_element(all), 10 * end);
  // a cubic between 0 and 1 stays below 1.07
  EXPECT_LE(*std::ranges::max_element(ended), 1.07 * 1.07 * end);
  EXPECT_LE(difference_of(view, blocks, ended, all).rms, 5e-3);  // beside kinks all is as far off
}

using LightLatticeGpu = GpuTest;

TEST_F(LightLatticeGpu, DepthsAreThoseInDouble) {
  GlRenderer& gl = *Gpu::renderer();
  for (const std::string& function :
       {std::string(), lattice_function_file(), clear_function_file(), gradient_function_file()})
    for (const glm::dvec3& direction : oblique) {
      Scene scene = lit_scene(direction);
      scene.transfer_function = function;
      if (!function.empty()) scene.extinction = 0.05;
      const View view = view_of(scene, mixed());
      const MediumAtlas atlas = build_medium_atlas(view);
      gl.upload(atlas);
      const std::vector<glm::ivec3> blocks = blocks_of(view);
      const Difference d = difference_of(
          view, blocks, depths_of(view, gl.light_depths(view), blocks, {.spacing = 0.5}),
          depths_of(view, march_double_light_depths(view, atlas), blocks, {.spacing = 0.5}));
      // places are double in both; values are float, and a brick's depth is a sum of sixteen
      EXPECT_LE(d.rms, 1e-6) << function;
      EXPECT_LE(d.max, 4e-6) << function;
    }
}

}  // namespace
}  // namespace psivox
