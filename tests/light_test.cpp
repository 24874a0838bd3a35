// Depths towards light from voxels, by three methods: against closed forms and each other. Where
// the light is stored.

#include "march/light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "field_voxels.h"
#include "light_cases.h"
#include "march_cases.h"

namespace psivox {
namespace {

const glm::dvec3 directions[] = {{0, 0, -1}, {0, 1, 0}, {-0.3, -1, 0.2}, {1, 1, 1}, {0.6, 0, -0.8}};

std::vector<double> gl_depths(const View& view, const std::vector<glm::ivec3>& origins,
                              const gl::TestLimits& limits = {}) {
  GlRenderer& gl = *Gpu::renderer();
  const MediumAtlas atlas = build_medium_atlas(view);
  const Limited limited(limits);
  gl.upload(atlas);
  return depths_of(view, gl.light_depths(view), origins);
}
std::vector<double> double_depths(const View& view, const std::vector<glm::ivec3>& origins) {
  const MediumAtlas atlas = build_medium_atlas(view);
  return depths_of(view, march_double_light_depths(view, atlas), origins);
}
TEST(LightDepths, OfASlabAreItsThickness) {
  // 16 voxels of 1 along z, wide in x and y, voxels of 0.5: from z to the face at 15.5.
  const double h = 0.5, K = 0.7;
  Scene scene = lit_scene({0, 0, -1});
  scene.extinction = K;
  const Field slab = make_field(
      {{-40, -40, 0}, {39, 39, 15}}, [](glm::ivec3) { return 1.f; }, glm::dmat4(glm::dmat3(h)));
  for (const double tilt : {0.0, 0.5}) {
    scene.lights.front().direction = {-tilt, 0, -1};
    const double length = h * std::sqrt(1 + tilt * tilt);  // length of the ray per voxel of z
    const View view = view_of(scene, slab);
    const std::vector<glm::ivec3> block = {{0, 0, 0}, {0, 0, 8}, {0, 0, 16}, {0, 0, -8}};
    const std::vector<double> march = double_depths(view, block);
    const std::vector<double> reference = depths_of(view, reference_light_depths(view), block);
    for (std::size_t i = 0; i < march.size(); ++i) {
      const int z = block[i / 512].z + static_cast<int>(i & 7);
      if (z < -1) continue;  // outside the domain, where no light is computed
      const double exact = K * length * (z > 15 ? 0 : z < 0 ? 16 : 15.5 - z);
      // sums of about 20 terms of this size in double
      EXPECT_NEAR(march[i], exact, 1e-13) << z;
      EXPECT_NEAR(reference[i], exact, 1e-13) << z;
    }
  }
}

TEST(LightDepths, CanBeStopped) {
  struct Stop {};
  const View view = view_of(lit_scene({0, 0, -1}), mixed());
  EXPECT_THROW(lit(view, reference_light_depths(view), [](double) { throw Stop(); }), Stop);
}

TEST(LightDepths, MarchAndReferenceAgree) {
  for (const glm::dvec3& direction : directions) {
    const View view = view_of(lit_scene(direction), mixed());
    const std::vector<glm::ivec3> origins = blocks_of(view);
    // Both are exact, but a ray along the faces of cells may take either side of them, which share
    // one value there. The bound allows hundreds of roundings of depths up to 40.
    EXPECT_LE(difference_of(view, origins, double_depths(view, origins),
                            depths_of(view, reference_light_depths(view), origins))
                  .max,
              1e-12)
        << direction.x << ' ' << direction.y << ' ' << direction.z;
  }
}

TEST(LightDepths, OfTheDomainsOwnFacesAreThoseAlongThem) {
  // A vacuum that attenuates fills the domain up to its faces, and light runs along four of them.
  Scene scene = lit_scene({0, 0, -1});
  scene.extinction = 0.1;
  View view = view_of(scene, make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return 0.f; }));
  view.medium.transfer = function({{0, 1}, {1, 1}});
  for (const int axis : {0, 1, 2})
    for (const double way : {-1.0, 1.0}) {
      glm::dvec3 direction(0);
      direction[axis] = way;
      view.medium.light->lights.front().direction = direction;
      const std::vector<glm::ivec3> origins = blocks_of(view);
      EXPECT_EQ(origins.size(), 27u);  // its domain is from -1 to 8
      const std::vector<double> march = double_depths(view, origins);
      const std::vector<double> reference = depths_of(view, reference_light_depths(view), origins);
      for (std::size_t i = 0; i < march.size(); ++i) {
        const glm::ivec3 voxel = origins[i / 512] + leaf_voxel(int(i % 512));
        if (!view.medium.density->domain().contains(voxel)) continue;
        const int way_out = way < 0 ? 8 - voxel[axis] : voxel[axis] + 1;
        EXPECT_NEAR(march[i], 0.1 * way_out, 1e-13);
        EXPECT_NEAR(reference[i], 0.1 * way_out, 1e-13);
      }
    }
}

TEST(VisibleBlocks, HoldEveryCornerOfACellWithAttenuation) {
  const Field field = mixed();
  const std::vector<glm::ivec3> origins = visible_blocks(field, {});
  const FieldVoxels at(field);
  const auto listed = [&](const glm::ivec3& v) {
    return std::find(origins.begin(), origins.end(), v & ~7) != origins.end();
  };
  const Box domain = field.domain();
  int cells = 0;
  for (int x = domain.min.x; x < domain.max.x; x += 1)
    for (int y = domain.min.y; y < domain.max.y; y += 3)
      for (int z = domain.min.z; z < domain.max.z; z += 3) {
        bool any = false;
        for (int i = 0; i < 8; ++i) any |= at({x + (i >> 2), y + (i >> 1 & 1), z + (i & 1)}).x != 0;
        if (!any) continue;
        ++cells;
        for (int i = 0; i < 8; ++i)
          ASSERT_TRUE(listed({x + (i >> 2), y + (i >> 1 & 1), z + (i & 1)}));
      }
  EXPECT_GT(cells, 1000);
  for (std::size_t i = 1; i < origins.size(); ++i) EXPECT_NE(origins[i], origins[i - 1]);
  const BrickAtlas atlas = build_atlas(field, {.own_texels = true});
  ASSERT_TRUE(atlas.own_texels);
  EXPECT_EQ(visible_blocks(field, {}, atlas), origins);
  EXPECT_FALSE(visible_blocks(field, {}, build_atlas(field)));
  // A field of 0 has no visible blocks; with a function that attenuates at 0 the whole domain is
  // visible.
  EXPECT_TRUE(
      visible_blocks(make_field({{0, 0, 0}, {7, 7, 7}}, [](auto) { return 0.f; }), {}).empty());
  AtlasOptions all;
  all.visible = [](const ValueRange&, const ValueRange&) { return true; };
  EXPECT_EQ(
      visible_blocks(make_field({{0, 0, 0}, {7, 7, 7}}, [](auto) { return 0.f; }), all).size(),
      27u);
}

using LightGpu = GpuTest;

TEST_F(LightGpu, DepthsAreThoseInDouble) {
  Scene scene = lit_scene({0, 0, -1});
  for (const std::string way : {"", ", function", ", labels"}) {
    const bool function = !way.empty();
    if (function) scene.transfer_function = function_file();
    if (way == ", labels") scene.classification = Classification::nearest;
    for (const glm::dvec3& direction : directions) {
      if (function && &direction != &directions[2]) continue;  // it is the same in all
      scene.lights.front().direction = direction;
      const View view = view_of(scene, mixed());
      const std::vector<glm::ivec3> origins = blocks_of(view);
      const std::vector<double> gpu = gl_depths(view, origins);
      const Difference d = difference_of(view, origins, gpu, double_depths(view, origins));
      std::printf("  light %g,%g,%g%s: rms %.2e, max %.2e\n", direction.x, direction.y, direction.z,
                  way.c_str(), d.rms, d.max);
      // float32 positions over 64 voxels are accurate to 4e-6 voxels. A depth's error is that times
      // a change of attenuation of about 1 at each, and these do not add up. Where a value crosses
      // the function's jump of 1.7 slowly, the place of the jump is off by that over the value's
      // slope, at least a tenth for the few rays that graze it.
      EXPECT_LE(d.rms, 1e-6);
      EXPECT_LE(d.max, function ? 1e-4 : 4e-6);
    }
  }
}

TEST_F(LightGpu, PassesDoNotChangeDepths) {
  const View view = view_of(lit_scene({-0.3, -1, 0.2}), mixed());
  const std::vector<glm::ivec3> origins = blocks_of(view);
  EXPECT_EQ(gl_depths(view, origins), gl_depths(view, origins, {.turns_per_pass = 16}));
}

TEST_F(LightGpu, PictureIsThatInDouble) {
  Scene scene = lit_scene({-0.3, -1, 0.2}, 64);
  scene.phase_g = 0.4;
  const View view = view_of(scene, mixed());
  GlRenderer& gl = *Gpu::renderer();
  MediumAtlas atlas = build_medium_atlas(view);
  EXPECT_FALSE(atlas.luminance);
  gl.upload(atlas);
  const View own = lit(view, gl.light_depths(view));
  add_luminance(atlas, own);
  const Image picture = render_gl(own, atlas).image;
  expect_content(picture);
  expect_arithmetic("lit", picture, double_picture(lit_in_double(view)));
}

/// The atlas of a view whose light is stored as any luminance is.
MediumAtlas light_apart(View view) {
  view.medium.lit = false;
  return build_medium_atlas(view);
}

/// A view's light in the density's bricks, as a session stores it, and in bricks of its own.
struct LitAtlases {
  View view;
  MediumAtlas beside, apart;
  explicit LitAtlases(const View& dark)
      : view(lit_in_double(dark)), beside(build_medium_atlas(dark)), apart(light_apart(view)) {
    add_luminance(beside, view);
  }
  /// The view marched in cells, or in steps.
  View by(Integrator rule, std::optional<double> step = {}) const {
    View other = view;
    other.scene = with(view.scene, rule, step);
    other.scene.sampling = step ? Sampling::uniform : Sampling::cells;
    return other;
  }
};

/// Lights of one colour, of two, and colours of a function.
std::vector<Scene> lit_scenes() {
  Scene one = lit_scene({-0.3, -1, 0.2}, 32), two = one, function = one;
  one.luminance = glm::dvec3(0.2);
  two.lights.push_back({{0.5, 0.3, -1}, {0.2, 0.3, 1}});
  function.transfer_function = function_file();
  return {one, two, function};
}

TEST(LightBesideTheDensity, IsTheSameInCellsAndNoFartherFromTheReferenceInSteps) {
  for (const Scene& scene : lit_scenes()) {
    const LitAtlases lit(view_of(scene, mixed()));
    ASSERT_TRUE(lit.beside.paired);
    ASSERT_FALSE(lit.apart.paired);
    for (const Integrator rule : {Integrator::cell_exact, Integrator::psi_weighted,
                                  Integrator::midpoint, Integrator::average}) {
      const Image image = render_double(lit.by(rule), lit.beside).image;
      expect_content(image);
      // The same values at the same places, but that pieces do not end where the ray meets the
      // faces of the luminance's cells, which are the density's; pictures are float32.
      EXPECT_LE(compare_images(image, render_double(lit.by(rule), lit.apart).image).max, 3e-7)
          << info(rule).name;
    }
    const Image truth = render_reference(lit.view).image;
    for (const Integrator rule :
         {Integrator::midpoint, Integrator::psi_balanced, Integrator::average}) {
      const View view = lit.by(rule, 0.5);
      const double beside = compare_images(render_double(view, lit.beside).image, truth).rms;
      const double apart = compare_images(render_double(view, lit.apart).image, truth).rms;
      std::printf("  %s: rms %.2e beside, %.2e apart\n", info(rule).name, beside, apart);
      // The first and the last sample of a body may differ, by an error of their own step.
      EXPECT_LE(beside, 1.1 * apart);
    }
  }
}

TEST_F(LightGpu, PicturesOfLightBesideTheDensityAreThoseInDouble) {
  const std::vector<Scene> scenes = lit_scenes();
  const LitAtlases white(view_of(scenes.front(), mixed())), jumps(view_of(scenes.back(), mixed()));
  for (const LitAtlases* lit : {&white, &jumps}) {
    expect_arithmetic("cells", lit->by(Integrator::cell_exact), lit->beside);
    // a middle may fall to either side of the function's jump
    const Integrator rule = lit == &jumps ? Integrator::psi_balanced : Integrator::midpoint;
    expect_arithmetic("steps", lit->by(rule, 0.5), lit->beside);
  }
  // the driver's filter reads both apart; it rounds weights and has quadratics only
  View filtered = white.view;
  filtered.scene.filter = Filter::hardware;
  const Comparison c = difference("filtered", render_gl(filtered, white.beside).image,
                                  render_double(filtered, white.beside).image);
  EXPECT_LE(c.rms, 5e-4);
  EXPECT_LE(c.max, 5e-3);
}

}  // namespace
}  // namespace psivox
