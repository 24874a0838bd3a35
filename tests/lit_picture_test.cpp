// Pictures of lit media: against closed forms, and how lights, luminance and emission add.

#include <gtest/gtest.h>

#include <cmath>

#include "light_cases.h"
#include "march_cases.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

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
  // the same segments and weights; sums are rounded to float32 at voxels and in the pictures
  expect_sum(both, light, glow, 2e-6);
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

TEST(Lit, ColoursOfAFunctionAreLeftToRays) {
  Scene scene = lit_scene({0, 0, -1}, 32);
  scene.transfer_function = function_file();
  scene.lights.front().color = {1, 2, 3};
  const View view = view_of(scene, mixed());
  const View own = lit_in_double(view);
  EXPECT_EQ(own.medium.source, LuminanceSource::scalar) << "one light needs one channel";
  EXPECT_EQ(own.medium.color, glm::dvec3(1, 2, 3));
  EXPECT_TRUE(own.medium.lit_colors && own.medium.transfer->has_color());
  const std::vector<glm::ivec3> origins = blocks_of(view);
  const std::vector<double> depths = double_depths(view, origins);
  const FieldVoxels light(*own.medium.luminance);
  for (std::size_t i = 0; i < depths.size(); i += 37) {
    const int n = static_cast<int>(i % 512);
    const glm::ivec3 v = origins[i / 512] + glm::ivec3(n >> 6, (n >> 3) & 7, n & 7);
    const double expected = std::exp(-depths[i]);
    // the exponential is float32's, of a depth that is rounded to it, and so is the light
    ASSERT_NEAR(light(v).x, expected, (2e-7 + 2e-7 * depths[i]) * expected);
  }
}

using LitFunction = GpuTest;

TEST_F(LitFunction, AFaintLightChangesNoPicture) {
  struct Way {
    const char* name;
    Classification classification;
    Integrator integrator;
    bool split_knots;
  };
  for (const Way& way :
       {Way{"exact cells", Classification::post, Integrator::cell_exact, true},
        {"labels", Classification::nearest, Integrator::cell_exact, true},
        {"split segments", Classification::post, Integrator::psi_exact, true},
        {"segments", Classification::post, Integrator::psi_weighted, false},
        {"preintegrated", Classification::post, Integrator::preintegrated, false}}) {
    Scene dark = small_scene(32);
    dark.transfer_function = function_file();
    dark.luminance = glm::dvec3(1, 0.5, 0.7);
    dark.classification = way.classification;
    dark.integrator = way.integrator;
    dark.split_knots = way.split_knots;
    Scene faint = dark;
    faint.lights = {{{0.3, -1, 0.2}, {1e-9, 1e-9, 1e-9}}};
    const auto density = share(mixed());
    const View without = view_of(dark, density), with = lit_in_double(view_of(faint, density));
    const Image image = double_picture(without);
    expect_content(image);
    EXPECT_LE(difference(std::string(way.name) + ", double", double_picture(with), image).max,
              1e-6);
    EXPECT_LE(difference("GPU", gl_picture(with), gl_picture(without)).max, 1e-6);
    if (way.integrator != Integrator::cell_exact) continue;
    const Image truth = render_reference(without).image;
    EXPECT_LE(difference("reference", render_reference(with).image, truth).max, 1e-6);
  }
}

/// Draws in light of one channel, and of three; `most`: what may be between it and the reference.
void expect_light_of_the_reference(Scene scene, double most) {
  scene.integrator = Integrator::cell_exact;
  for (const int lights : {1, 2}) {
    if (lights == 2) scene.lights.push_back({{-1, 0.2, -1}, {0.1, 0.5, 0.9}});
    const View view = lit_in_double(view_of(scene, mixed()));
    EXPECT_EQ(view.medium.luminance->channels, lights == 1 ? 1 : 3);
    const Image image = double_picture(view);
    expect_content(image);
    EXPECT_LE(difference("reference", image, render_reference(view).image).max, most);
    EXPECT_LE(difference("GPU", gl_picture(view), image).rms, 2e-6);
  }
}

TEST_F(LitFunction, ColoursInLightAreThoseOfTheReference) {
  Scene scene = lit_scene({0.3, -1, 0.2}, 32);
  scene.transfer_function = function_file();
  // what the rule for cells leaves, and what float32 makes of a function that jumps
  expect_light_of_the_reference(scene, 1e-5);
}

TEST_F(LitFunction, LabelsInAnOutsideThatAttenuatesAreThoseOfTheReference) {
  Scene scene = lit_scene({0.3, -1, 0.2}, 32);
  scene.colormap = Colormap::viridis;
  scene.classification = Classification::nearest;
  set_parameter(scene, "opacity", "0:1,1:0");
  expect_light_of_the_reference(scene, 1e-6);
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
    MediumFields fields{density, nullptr, nullptr};
    if (emits) fields.emission = {{&emission_options[0], share(fire)}};
    const View view = make_view(of, fields);
    return double_picture(!of.lights.empty() ? lit_in_double(view) : view);
  };
  const Image light = picture(scene, false);
  const Image both = picture(scene, true);
  Scene dark = scene;
  dark.lights.clear();
  dark.luminance = glm::dvec3(0);
  const Image emission = picture(dark, true);
  expect_content(light);
  expect_sum(both, light, emission, 2e-6);  // of two float32 pictures
  EXPECT_GT(std::ranges::max(emission.rgba()), 0.05f);
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
