// Light scattered once. Computes its depths from voxels by three methods, compares them with closed
// forms and with each other, and checks the pictures.

#include "march/light.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "field_voxels.h"
#include "light_cases.h"
#include "march_cases.h"

namespace psivox {
namespace {

/// A function whose attenuation turns at several values, in a file of its own.
std::string function_file() {
  const auto path = std::filesystem::temp_directory_path() /
                    ("psivox_light_" + std::to_string(::getpid()) + ".json");
  std::ofstream(path) << R"({"points": [
    {"value": 0, "attenuation": 0, "color": [1, 1, 1]},
    {"value": 0.2, "attenuation": 1, "color": [1, 0.5, 0.25]},
    {"value": 0.5, "attenuation": 0.3, "color": [0.5, 1, 0.5]},
    {"value": 0.50001, "attenuation": 2, "color": [0, 1, 1]},
    {"value": 1, "attenuation": 0.5, "color": [1, 0, 1]}]})";
  return path.string();
}

View lit_in_double(const View& view) {
  const MediumAtlas atlas = build_medium_atlas(view);
  return lit(view, march_double_light_depths(view, atlas));
}

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
/// Difference of the transmittances.
Difference difference_of(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  Difference d;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double off = std::abs(std::exp(-a[i]) - std::exp(-b[i]));
    d.max = std::max(d.max, off);
    d.rms += off * off;
  }
  d.rms = std::sqrt(d.rms / static_cast<double>(a.size()));
  return d;
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

TEST(LightDepths, MarchAndReferenceAgree) {
  for (const glm::dvec3& direction : directions) {
    const View view = view_of(lit_scene(direction), mixed());
    const std::vector<glm::ivec3> origins = blocks_of(view);
    // Both are exact, but a ray along the faces of cells may take either side of them, which share
    // one value there. The bound allows hundreds of roundings of depths up to 40.
    EXPECT_LE(difference_of(double_depths(view, origins),
                            depths_of(view, reference_light_depths(view), origins))
                  .max,
              1e-12)
        << direction.x << ' ' << direction.y << ' ' << direction.z;
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
  for (const bool function : {false, true}) {
    if (function) scene.transfer_function = function_file();
    for (const glm::dvec3& direction : directions) {
      scene.lights.front().direction = direction;
      const View view = view_of(scene, mixed());
      const std::vector<glm::ivec3> origins = blocks_of(view);
      const std::vector<double> gpu = gl_depths(view, origins);
      const Difference d = difference_of(gpu, double_depths(view, origins));
      std::printf("  light %g,%g,%g%s: rms %.2e, max %.2e\n", direction.x, direction.y, direction.z,
                  function ? ", function" : "", d.rms, d.max);
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
  const Comparison c = difference("lit", picture, double_picture(lit_in_double(view)));
  expect_content(picture);
  // float32 sums of a ray, as elsewhere (march_test), plus T_light's own 1e-6
  EXPECT_LE(c.max, 2e-5);
  EXPECT_LE(c.rms, 1e-6);
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
};

/// Lights of one colour, of two, and colours of a function.
std::vector<Scene> lit_scenes() {
  Scene one = lit_scene({-0.3, -1, 0.2}, 64), two = one, function = one;
  one.luminance = glm::dvec3(0.2);
  two.lights.push_back({{0.5, 0.3, -1}, {0.2, 0.3, 1}});
  function.transfer_function = function_file();
  return {one, two, function};
}

TEST(LightBesideTheDensity, IsTheSameInCells) {
  for (Scene scene : lit_scenes())
    for (const Integrator rule : {Integrator::cell_exact, Integrator::psi_weighted,
                                  Integrator::midpoint, Integrator::average}) {
      scene.integrator = rule;
      const LitAtlases lit(view_of(scene, mixed()));
      ASSERT_TRUE(lit.beside.paired);
      ASSERT_FALSE(lit.apart.paired);
      const Image image = render_double(lit.view, lit.beside).image;
      expect_content(image);
      // The same values at the same places, but that pieces do not end where the ray meets the
      // faces of the luminance's cells, which are the density's; pictures are float32.
      EXPECT_LE(compare_images(image, render_double(lit.view, lit.apart).image).max, 3e-7)
          << info(rule).name;
    }
}

TEST(LightBesideTheDensity, IsNoFartherFromTheReferenceInSteps) {
  for (Scene scene : lit_scenes())
    for (const Integrator rule :
         {Integrator::midpoint, Integrator::psi_balanced, Integrator::average}) {
      scene.integrator = rule;
      scene.step = 0.5;
      const LitAtlases lit(view_of(scene, mixed()));
      const Image truth = render_reference(lit.view).image;
      const double beside = compare_images(render_double(lit.view, lit.beside).image, truth).rms;
      const double apart = compare_images(render_double(lit.view, lit.apart).image, truth).rms;
      std::printf("  %s: rms %.2e beside, %.2e apart\n", info(rule).name, beside, apart);
      // The first and the last sample of a body may differ, by an error of their own step.
      EXPECT_LE(beside, 1.1 * apart);
    }
}

TEST_F(LightGpu, PicturesOfLightBesideTheDensityAreThoseInDouble) {
  const std::vector<Scene> scenes = lit_scenes();
  const auto expect_same = [](const Scene& scene, double rms, double max) {
    const LitAtlases lit(view_of(scene, mixed()));
    const Image picture = render_gl(lit.view, lit.beside).image;
    const Comparison c = difference("beside", picture, render_double(lit.view, lit.beside).image);
    EXPECT_LE(c.rms, rms);
    EXPECT_LE(c.max, max);
  };
  for (Scene scene : {scenes.front(), scenes.back()}) {
    scene.integrator = Integrator::cell_exact;
    expect_same(scene, 1e-6, 2e-5);  // as in PictureIsThatInDouble
    // a middle may fall to either side of the function's jump
    const bool jumps = !scene.transfer_function.empty();
    scene.integrator = jumps ? Integrator::psi_balanced : Integrator::midpoint;
    scene.step = 0.5;
    expect_same(scene, 1e-6, 2e-5);
  }
  // the driver's filter reads both apart; it rounds weights and has quadratics only
  Scene filtered = scenes.front();
  filtered.filter = Filter::hardware;
  expect_same(filtered, 5e-4, 5e-3);
}

// --- pictures ------------------------------------------------------------------------------------

/// The middle pixel of a slab 16 voxels thick, seen along -z, lit along `direction`.
glm::dvec3 slab_picture(Scene scene, double K) {
  scene.extinction = K;
  scene.resolution = {9, 9};
  const Field slab = make_field({{-40, -40, 0}, {39, 39, 15}}, [](glm::ivec3) { return 1.f; });
  scene = looking(scene, {-0.5, -0.5, 60}, {-0.5, -0.5, 8}, 8.0);
  const Image image = double_picture(lit_in_double(view_of(scene, slab)));
  return {pixel(image, 4, 4, 0), pixel(image, 4, 4, 1), pixel(image, 4, 4, 2)};
}

TEST(Lit, SlabFromTheFrontHasAClosedForm) {
  // I = integral of K e^{-Ks} e^{-Ks} ds = (1 - e^{-2D}) / 2, D = 16 K.
  for (const double K : {0.02, 0.05}) {
    Scene scene = lit_scene({0, 0, -1});
    scene.lights.front().color = {1, 2, 0};
    scene.albedo = glm::dvec3(0.5);
    const glm::dvec3 I = slab_picture(scene, K);
    const double exact = 0.5 * -std::expm1(-2 * 16 * K) / 2;
    // e^{-Ks} is interpolated linearly between voxels, which costs at most K^2/8 of it. The tents
    // at the ends, where the depth is quadratic, cost about as much.
    EXPECT_NEAR(I.x, exact, exact * K * K / 4);
    EXPECT_NEAR(I.y, 2 * exact, 2 * exact * K * K / 4);
    EXPECT_EQ(I.z, 0);
  }
}

TEST(Lit, SlabFromBehindHasAClosedForm) {
  // Each point is lit through D - Ks and seen through Ks: I = D e^{-D}.
  const double K = 0.05, D = 16 * K;
  const glm::dvec3 I = slab_picture(lit_scene({0, 0, 1}), K);
  EXPECT_NEAR(I.x, D * std::exp(-D), D * std::exp(-D) * K * K / 4);
}

TEST(Lit, PhaseIsAFactorOfTheRay) {
  Scene scene = lit_scene({0, 0, -1});
  const glm::dvec3 isotropic = slab_picture(scene, 0.05);
  // The camera looks along the light, so it sees backscattered light.
  for (const double g : {0.5, -0.3}) {
    scene.phase_g = g;
    // pictures are float32
    EXPECT_NEAR(slab_picture(scene, 0.05).x / isotropic.x, (1 - g * g) / std::pow(1 + g, 3), 1e-6);
  }
}

TEST(Lit, OctavesOfASlabHaveAClosedForm) {
  // Light along the view: I = sum of a^i K e^{-Ks} e^{-a^i Ks} ds = a^i (1 - e^{-(1+a^i)D}) /
  // (1+a^i), each with the phase of g a^i, which is no factor of the ray any more.
  const double K = 0.05, D = 16 * K, g = 0.5;
  Scene scene = lit_scene({0, 0, -1});
  scene.phase_g = g;
  for (const int octaves : {2, 5}) {
    scene.scatter_octaves = octaves;
    double exact = 0;
    for (double a = 1; a > std::exp2(-octaves); a /= 2)
      exact +=
          a * (1 - g * a * g * a) / std::pow(1 + g * a, 3) * -std::expm1(-(1 + a) * D) / (1 + a);
    // as above
    EXPECT_NEAR(slab_picture(scene, K).x, exact, exact * K * K / 4);
  }
}

TEST(Lit, WithoutLightOfItsOwnAMediumOfLuminanceOneIsItsOpacity) {
  // The light adds nothing. The remaining luminance is 1 at every voxel that a cell with
  // attenuation reads, so radiance and opacity are the same number in every pixel.
  for (const bool uniform : {false, true}) {
    Scene scene = lit_scene({0.3, -1, 0.2}, 64);
    scene.lights.front().color = {0, 0, 0};
    scene.luminance = glm::dvec3(1);
    if (uniform) scene.step = 0.5;
    const Image image = double_picture(lit_in_double(view_of(scene, mixed())));
    expect_content(image);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x)
        // Roundings of float32 pictures of at most 1. Under uniform steps the luminance of a first
        // sample outside all blocks is missing: up to a step's opacity.
        ASSERT_NEAR(pixel(image, x, y, 0), pixel(image, x, y, 3), uniform ? 2e-2 : 1e-6)
            << x << ' ' << y;
  }
}

TEST(Lit, LightAndLuminanceAdd) {
  Scene dark = lit_scene({0.3, -1, 0.2}, 32);
  const Field density = mixed();
  const auto shared = share(density);
  const Image light = double_picture(lit_in_double(view_of(dark, shared)));
  Scene glowing = dark;
  glowing.lights.clear();
  const Image glow = double_picture(view_of(glowing, shared, Glow::density));
  const Image both = double_picture(lit_in_double(view_of(dark, shared, Glow::density)));
  expect_content(light);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      // the same segments and weights; sums are rounded to float32 at voxels and in the pictures
      ASSERT_NEAR(pixel(both, x, y, 0), pixel(light, x, y, 0) + pixel(glow, x, y, 0), 2e-6);
}

TEST(Lit, LuminanceOfAnotherGridIsTakenAtVoxels) {
  // Linear over the world, so that interpolating it at the density's voxels loses nothing.
  Scene scene = lit_scene({0.3, -1, 0.2}, 32);
  scene.lights.front().color = {0, 0, 0};
  Field glow = make_field(
      {{-40, -40, -40}, {40, 40, 40}},
      [](glm::ivec3 v) { return 2 + 0.01f * static_cast<float>(v.x + 2 * v.y - v.z); },
      glm::dmat4(glm::dmat3(1.7)));
  glow.name = "glow";
  const Image lit_image = double_picture(lit_in_double(view_of(scene, mixed(), glow)));
  scene.lights.clear();
  const Image image = double_picture(view_of(scene, mixed(), glow));
  expect_content(image);
  // values of up to 5 as float32, at voxels and in the pictures
  EXPECT_LE(compare_images(lit_image, image).max, 3e-6);
}

TEST(Lit, ColoursOfAFunctionTintTheLight) {
  Scene scene = lit_scene({0, 0, -1}, 32);
  scene.transfer_function = function_file();
  scene.lights.front().color = {1, 2, 3};
  const View view = view_of(scene, mixed());
  const View own = lit_in_double(view);
  EXPECT_EQ(own.medium.source, LuminanceSource::vector);
  const std::vector<glm::ivec3> origins = blocks_of(view);
  const std::vector<double> depths = double_depths(view, origins);
  const FieldVoxels at(*view.medium.density), light(*own.medium.luminance);
  for (std::size_t i = 0; i < depths.size(); i += 37) {
    const int n = static_cast<int>(i % 512);
    const glm::ivec3 v = origins[i / 512] + glm::ivec3(n >> 6, (n >> 3) & 7, n & 7);
    const glm::dvec3 color = view.medium.transfer->at(at(v).x).color;
    const glm::dvec3 L = own.medium.color * glm::dvec3(light(v));
    for (int c = 0; c < 3; ++c) ASSERT_EQ(L[c], float((c + 1) * color[c] * std::exp(-depths[i])));
  }
}

TEST(Lit, AmbientLightHasNoPhase) {
  Scene scene = lit_scene({0.3, 0, -1}, 32);
  scene.phase_g = 0.5;
  scene.lights.front().color = {1, 0.5, 0.25};
  scene.integrator = Integrator::cell_exact;
  const Image light = double_picture(lit_in_double(view_of(scene, mixed())));
  scene.luminance = glm::dvec3(0.3, 0.4, 0.5);
  const View both = lit_in_double(view_of(scene, mixed()));
  EXPECT_EQ(both.medium.source, LuminanceSource::scalar) << "one light needs one channel";
  const Image image = double_picture(both);
  const Image reference = render_reference(both).image;
  // what the rule for cells leaves; without the ambient light it would be 0.3
  EXPECT_LE(compare_images(image, reference).max, 1e-5);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x)
      for (int c = 0; c < 3; ++c)
        // sums of two float32 numbers
        ASSERT_NEAR(pixel(image, x, y, c),
                    pixel(light, x, y, c) + (0.3 + 0.1 * c) * pixel(image, x, y, 3), 3e-7);
}

TEST(Lit, EmissionHasNoPhase) {
  Scene scene = lit_scene({0, 0, -1}, 32);
  scene.phase_g = 0.5;
  const auto density = share(mixed());
  Field fire = blobs();
  fire.name = scene.emission_grid = "fire";
  scene.emission_scale = 0.1;
  const auto picture = [&](const Scene& of, bool emits) {
    const View view =
        make_view(of, MediumFields{density, nullptr, nullptr, emits ? share(fire) : nullptr});
    return double_picture(!of.lights.empty() ? lit_in_double(view) : view);
  };
  const Image light = picture(scene, false);
  const Image both = picture(scene, true);
  Scene dark = scene;
  dark.lights.clear();
  dark.luminance = glm::dvec3(0);
  const Image emission = picture(dark, true);
  expect_content(light);
  double most = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      most = std::max(most, static_cast<double>(pixel(emission, x, y, 0)));
      // sums of two float32 pictures
      ASSERT_NEAR(pixel(both, x, y, 0), pixel(light, x, y, 0) + pixel(emission, x, y, 0), 2e-6);
    }
  EXPECT_GT(most, 0.05);
}

TEST(Lit, IsNothingWithoutLight) {
  const View view = view_of(small_scene(), blobs());
  const View same = lit(view, [](auto&&...) { throw 1; });
  EXPECT_EQ(same.medium.source, LuminanceSource::constant);
  EXPECT_EQ(same.medium.luminance, nullptr);
  // a light that has not been computed is an error
  const View pending = view_of(lit_scene({0, 0, 1}), blobs());
  EXPECT_THROW(double_picture(pending), Error);
  EXPECT_THROW(render_reference(pending), Error);
}

}  // namespace
}  // namespace psivox
