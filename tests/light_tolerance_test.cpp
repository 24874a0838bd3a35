// A tolerance covers the light: pictures of lit scenes against the reference, which computes its
// own light exactly, and skies against closed forms.

#include <gtest/gtest.h>

#include <cmath>

#include "march_cases.h"
#include "psivox/draw.h"
#include "scratch.h"

namespace psivox {
namespace {

struct LitScene {
  const char* name;
  Scene scene;
  Field density;
  bool glows = false;  ///< its density is its luminance too
  std::shared_ptr<const Field> second{};
};

Scene lit_by(std::vector<DirectionalLight> lights, double extinction = 0.15) {
  Scene scene;
  scene.resolution = {64, 48};
  scene.extinction = extinction;
  scene.lights = std::move(lights);
  return scene;
}

Scene with_phase(Scene scene, double g) {
  scene.phase_g = g;
  return scene;
}

Scene with_function(Scene scene) {
  scene.transfer_function = test::write_bytes("function.json", R"({"points": [
    {"value": 0, "attenuation": 0, "color": [1, 1, 1]},
    {"value": 0.3, "attenuation": 0.6, "color": [1, 0.5, 0.25]},
    {"value": 0.6, "attenuation": 0.1, "color": [0.5, 1, 1]},
    {"value": 1, "attenuation": 1, "color": [1, 0.8, 0.6]}]})")
                                .string();
  return scene;
}

const glm::dvec3 white(1);
/// A few hundred voxels, because the reference looks from each in every direction of a sky.
const glm::dmat4 voxels_of_two(glm::dmat3(2));

std::vector<LitScene> tolerance_scenes() {
  Scene bright = lit_by({{{-0.3, -1, 0.2}, {3, 2, 1}}});
  bright.albedo = {0.6, 0.9, 0.2};
  Scene glowing = lit_by({{{0.6, 0.1, -0.8}, white}});
  glowing.luminance_grid = "density";
  glowing.luminance = glm::dvec3(0.5, 0.2, 0.1);
  Scene two =
      with_phase(lit_by({{{1, -1, -1}, {1, 0.9, 0.8}}, {{-1, 0.2, -1}, {0.1, 0.2, 0.3}}}), -0.3);
  two.luminance = glm::dvec3(0.2);
  Scene scattered = lit_by({{{-0.3, -1, 0.2}, white}}, 3), scattered_ahead = two;
  scattered.scatter_octaves = 8;
  scattered_ahead.scatter_octaves = 3;
  const auto turned = share(blobs({8, 4, -6}, sheared));
  return {
      {"two volumes", lit_by({{{-0.3, -1, 0.2}, white}}), mixed(), false, turned},
      {"two volumes, two lights", two, blobs(), false, share(mixed(sheared))},
      {"nearly along a face", lit_by({{{0.013, -1, 0.027}, white}}), mixed()},
      {"sheared and rotated", lit_by({{{0.4, -1, -0.3}, white}}, 0.4), mixed(sheared)},
      {"colours and albedo", bright, blobs()},
      {"glowing too", glowing, blobs(), true},
      {"phases of two lights", two, blobs()},
      {"octaves, dense", scattered, mixed()},
      {"octaves of two lights with phases", scattered_ahead, blobs()},
      {"a function's colours", with_function(lit_by({{{0.5, -1, -0.6}, white}})), mixed()},
      {"a function, rotated", with_function(lit_by({{{1, -1, -0.2}, white}}, 0.5)), mixed(sheared)},
      {"dense, lit from the camera", lit_by({{{0.5, -0.8, -1}, white, true}}, 3), mixed()}};
}

View lit_view(const LitScene& lit, std::optional<double> tolerance) {
  Scene scene = lit.scene;
  scene.tolerance = tolerance;
  View view = view_of(scene, lit.density, lit.glows ? Glow::density : Glow::constant);
  if (lit.second) view.medium.others.push_back(view_of(scene, lit.second).medium);
  return view;
}

using LitTolerance = GpuTest;

TEST_F(LitTolerance, HoldsAgainstTheReference) {
  const auto reference = open_reference();
  for (const LitScene& lit : tolerance_scenes()) {
    const Image truth = Session(lit_view(lit, {})).draw(*reference).image;
    expect_content(truth);
    for (const double E : {1e-2, 1e-3, 1e-4}) {
      const Drawn drawn = Session(lit_view(lit, E)).draw(*Gpu::renderer());
      const Comparison c = compare_images(drawn.image, truth);
      int far_off = 0;
      for (std::size_t i = 0; i < truth.rgba().size(); i += 4) {
        double squares = 0;
        for (std::size_t k = i; k < i + 4; ++k)
          squares += std::pow(double(drawn.image.rgba()[k]) - double(truth.rgba()[k]), 2);
        far_off += std::sqrt(squares / 4) > 5 * E;
      }
      const Trial& estimate = drawn.plan->chosen;
      std::printf(
          "  %-28s %.0e: rms %.2f E, estimate %.2f E, light %.2f E by %s; max %.2f E, "
          "estimate %.2f E; %s\n",
          lit.name, E, c.rms / E, estimate.rms / E, drawn.light->rms / E,
          drawn.light->method.c_str(), c.max / E, estimate.max / E,
          method_text(estimate.method).c_str());
      EXPECT_LE(c.rms, E) << lit.name;
      // of 3072 pixels, one in a thousand
      EXPECT_LE(far_off, 3) << lit.name << ' ' << E;
      // the estimate is of a sample of rays; above what float32 makes of the picture
      if (c.rms > 1e-6) {
        EXPECT_LE(estimate.rms, 3 * c.rms) << lit.name << ' ' << E;
        EXPECT_GE(estimate.rms, c.rms / 3) << lit.name << ' ' << E;
        // the largest of some hundred rays, against that of all
        EXPECT_LE(estimate.max, 3 * c.max) << lit.name << ' ' << E;
        EXPECT_GE(estimate.max, c.max / 3) << lit.name << ' ' << E;
      }
    }
  }
}

TEST_F(LitTolerance, ErrorLayerIncludesTheLight) {
  const LitScene lit{"", lit_by({{{-0.3, -1, 0.2}, white}}), mixed()};
  const Drawn drawn =
      Session(lit_view(lit, 3e-3)).draw(*Gpu::renderer(), {.layers = {.error = true}});
  ASSERT_GT(drawn.light->rms, 2e-4);
  Scene exact = lit.scene;
  exact.light_quality = LightQuality::exact;
  exact.tolerance = 1e-6;
  const Image truth = Session(view_of(exact, lit.density)).draw(*Gpu::renderer()).image;
  const double rms = compare_images(drawn.image, truth).rms;
  // the better picture misses a quarter of the light's error
  EXPECT_NEAR(drawn.difference->rms, rms, 0.1 * rms);
}

TEST_F(LitTolerance, ASkyHasTheDirectionsThatItsPhaseTakes) {
  // Smooth light takes few directions, a phase function's peak more: seen along x, its mean over 8
  // of them is 1.18, over 10 1.09, and over 32 1.003. That is off everywhere.
  Scene scene = with_phase(lit_by({}, 0.01), 0.5);
  scene = looking(scene, {-60, 5, 6}, {8, 5, 6}, 20);
  scene.sky = glm::dvec3(1, 0.5, 0.2);
  const Field density = make_field(
      {{0, 0, 0}, {7, 5, 6}}, [](glm::ivec3 v) { return 1 + 0.5f * noise(v); }, voxels_of_two);
  const LitScene lit{"", scene, density};
  const Image truth = Session(lit_view(lit, {})).draw(*open_reference()).image;
  for (const double E : {1e-2, 5e-3}) {
    const Drawn drawn = Session(lit_view(lit, E)).draw(*Gpu::renderer());
    const double rms = compare_images(drawn.image, truth).rms;
    std::printf("  %.0e: rms %.2e, estimate %.2e, %d directions\n", E, rms, drawn.plan->chosen.rms,
                drawn.light->beams);
    EXPECT_LE(rms, E);
    EXPECT_GE(drawn.plan->chosen.rms, rms / 3);
  }
}

/// A picture within a tolerance against the reference, whose estimate does not say far less.
void expect_kept(const LitScene& lit, double E, double honesty) {
  const Image truth = Session(lit_view(lit, {})).draw(*open_reference()).image;
  const Drawn drawn = Session(lit_view(lit, E)).draw(*Gpu::renderer());
  const double rms = compare_images(drawn.image, truth).rms, estimate = drawn.plan->chosen.rms;
  std::printf("  %-12s %.0e: rms %.2f E, estimate %.2f E, light by %s\n", lit.name, E, rms / E,
              estimate / E, drawn.light->method.c_str());
  EXPECT_LE(rms, E) << lit.name;
  EXPECT_GE(estimate, rms / honesty) << lit.name;
}

TEST_F(LitTolerance, HoldsWhereARaySeesAPartOfAVoxel) {
  Scene scene = lit_by({}, 47);
  scene.resolution = {48, 32};
  scene.sky = white;
  scene.azimuth = 11;
  scene.elevation = -43;
  const auto box = make_field({{0, 0, 0}, {7, 11, 3}}, [](glm::ivec3) { return 1.0f; });
  expect_kept({"dense box", scene, box}, 1e-3, 3);
  scene.extinction = 5;
  scene.scatter_octaves = 3;
  expect_kept({"octaves", scene, box}, 1e-3, 3);
  // columns do not converge here as they do in thin media
  const auto rough = make_field({{0, 0, 0}, {7, 5, 12}}, [](glm::ivec3 v) { return noise(v); });
  scene.extinction = 2.9;
  expect_kept({"rough", scene, rough}, 1e-2, 2);
}

TEST_F(LitTolerance, OfASkyHoldsForACloserCamera) {
  // The light of the picture before would be kept: two small things in the corners of a box cover a
  // fiftieth of it, and one of them fills the closer picture. They are dense: each voxel's rays
  // miss nothing, but the directions do.
  const auto density = make_field({{0, 0, 0}, {31, 31, 31}}, [](glm::ivec3 v) {
    const bool low = glm::all(glm::lessThan(v, glm::ivec3(4)));
    return low || glm::all(glm::greaterThan(v, glm::ivec3(27))) ? 0.5f + 0.5f * noise(v) : 0.0f;
  });
  Scene lit = lit_by({}, 10);
  lit.resolution = {48, 32};
  lit.sky = white;
  const Scene close = looking(lit, {12, 10, 30}, {1.5, 1.5, 1.5}, 4);
  constexpr double E = 5e-3;
  Session session(lit_view({"", looking(lit, {60, 40, 200}, {16, 16, 16}, 60), density}, E));
  (void)session.draw(*Gpu::renderer());
  Scene wanted = session.view().scene;
  wanted.camera_position = close.camera_position;
  wanted.camera_target = close.camera_target;
  wanted.ortho_width = close.ortho_width;
  const Drawn drawn = session.draw(*Gpu::renderer(), {.scene = wanted});
  const Image truth = Session(lit_view({"", close, density}, {})).draw(*open_reference()).image;
  const double rms = compare_images(drawn.image, truth).rms;
  std::printf("  closer %.0e: rms %.2f E, estimate %.2f E, %d directions\n", E, rms / E,
              drawn.plan->chosen.rms / E, drawn.light->beams);
  EXPECT_LE(rms, E);
  EXPECT_GE(drawn.plan->chosen.rms, rms / 3);
}

TEST_F(LitTolerance, HoldsForSmallThingsInAHaze) {
  const auto density = make_field({{0, 0, 0}, {21, 3, 14}}, [](glm::ivec3 v) {
    if (v == glm::ivec3(4, 2, 9)) return 50.0f;
    if (v == glm::ivec3(5, 1, 2)) return 40.0f;
    return v == glm::ivec3(10, 3, 13) ? 20.0f : 5e-4f;
  });
  Scene scene = looking(lit_by({}, 0.17), {-33, -2, 22.5}, {10.5, 1.5, 7}, 48);
  scene.resolution = {48, 32};
  scene.sky = white;
  expect_kept({"haze", scene, density}, 1e-3, 3);
}

TEST_F(LitTolerance, OctavesEndWhereTheLastOneDoes) {
  // at an optical depth of d every ray of the middle sees the sum over i of 2^-i e^(-d / 2^i)
  Scene scene = looking(lit_by({{{1, 0, 0}, white}}, 36), {8, 12, 14}, {8, 12, 5}, 1);
  scene.resolution = {9, 9};
  scene.scatter_octaves = 8;
  scene.light_quality = LightQuality::exact;
  const auto box = make_field({{0, 0, 0}, {23, 23, 23}}, [](glm::ivec3) { return 1.0f; });
  const Image image = Session(lit_view({"", scene, box}, {})).draw(*Gpu::renderer()).image;
  const double d = 36 * 8.5;
  double light = 0;
  for (int i = 0; i < 8; ++i) light += std::exp2(-i) * std::exp(-d * std::exp2(-i));
  EXPECT_NEAR(double(pixel(image, 4, 4, 0)), light, 1e-4 * light);
}

TEST_F(LitTolerance, HoldsForFunctionsOfTheGradient) {
  const auto rough = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) { return noise(v); });
  const auto shell = [&](double thickness) {
    Scene scene = lit_by({{{1, -1, -0.5}, white}}, 3);
    scene.resolution = {48, 32};
    scene.transfer_function =
        test::write_bytes("shell.json", R"({"points": [{"value": 0, "attenuation": 0}],
          "isosurfaces": [{"value": 0.5, "attenuation": 1, "thickness": )" +
                                            std::to_string(thickness) + "}]}")
            .string();
    return LitScene{"shell", scene, rough};
  };
  expect_kept(shell(1), 1e-4, 3);
  // 32 segments do not resolve it, and the estimate says so
  const LitScene thin = shell(0.1);
  const Image truth = Session(lit_view(thin, {})).draw(*open_reference()).image;
  const Drawn drawn = Session(lit_view(thin, 1e-4)).draw(*Gpu::renderer());
  EXPECT_FALSE(drawn.plan->reached);
  EXPECT_GE(drawn.plan->chosen.rms, compare_images(drawn.image, truth).rms / 3);
}

TEST_F(LitTolerance, ASolidOfTilesIsLitByColumns) {
  // a ray from each of its voxels crosses as many cells as in leaves
  DenseField solid("density", glm::ivec3(64), 1, glm::dmat4(1));
  for (int x = 0; x < 64; x += 8) solid.add(std::vector<float>(8 * 64 * 64, 1.0f));
  Field density = solid.finish();
  ASSERT_TRUE(density.leaves.empty());
  Scene scene = lit_by({{{-0.3, -1, 0.2}, white}}, 0.05);
  scene.tolerance = 1e-3;
  const Drawn drawn = Session(view_of(scene, std::move(density))).draw(*Gpu::renderer());
  EXPECT_TRUE(drawn.light->method.starts_with("columns")) << drawn.light->method;
}

TEST_F(LitTolerance, LightIsKeptBetweenCameras) {
  Session session(lit_view({"", lit_by({{{-0.3, -1, 0.2}, white}}), mixed()}, 1e-3));
  Drawn first = session.draw(*Gpu::renderer());
  EXPECT_GT(first.times.light_ms, 0);
  Scene turned = session.view().scene;
  turned.camera_position = glm::dvec3(150, 60, 20);
  const Drawn second = session.draw(*Gpu::renderer(), {.scene = turned});
  EXPECT_EQ(second.times.light_ms, 0);
  EXPECT_LE(second.light->rms, 0.5e-3);
  // A light of the camera turns with it.
  Session own(lit_view({"", lit_by({{{-0.3, -1, -0.2}, white, true}}), mixed()}, 1e-3));
  first = own.draw(*Gpu::renderer());
  const Drawn again = own.draw(*Gpu::renderer());
  EXPECT_EQ(again.times.light_ms, 0);
  const Drawn moved = own.draw(*Gpu::renderer(), {.scene = turned});
  EXPECT_GT(moved.times.light_ms, 0);
  // what it shows is what a scene with that light in the world shows
  Scene world = turned;
  const glm::dvec3 direction = from_camera(make_camera(turned, *own.view().subject),
                                           glm::normalize(glm::dvec3(-0.3, -1, -0.2)));
  world.lights = {{direction, white}};
  const Image same = Session(view_of(world, mixed())).draw(*Gpu::renderer()).image;
  EXPECT_LE(compare_images(moved.image, same).max, 1e-5);
}

TEST_F(LitTolerance, LightsAdd) {
  const DirectionalLight key{{1, -1, -1}, {1, 0.9, 0.8}}, fill{{-1, 0.2, -1}, {0.1, 0.2, 0.3}};
  const auto picture = [&](std::vector<DirectionalLight> lights) {
    Scene scene = lit_by(std::move(lights));
    scene.light_quality = LightQuality::exact;
    scene.sampling = Sampling::cells;
    return Session(view_of(scene, blobs())).draw(*Gpu::renderer()).image;
  };
  const Image a = picture({key}), b = picture({fill}), both = picture({key, fill});
  expect_content(both);
  expect_sum(both, a, b, 1e-6);  // three float32 pictures of at most 1
}

// --- furnaces: a uniform sky around a medium of albedo 1 -----------------------------------------

/// Integral of f from 0 to 1, by Simpson's rule.
template <typename F>
double integral(const F& f) {
  constexpr int n = 400;
  double sum = f(0.0) + f(1.0);
  for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * f(double(i) / n);
  return sum / (3 * n);
}

Image in_a_furnace(const Field& medium, double K, double E, double width, double distance,
                   const glm::dvec3& albedo = glm::dvec3(1)) {
  Scene scene;
  scene.albedo = albedo;
  scene.resolution = {9, 9};
  scene.extinction = K;
  scene.sky = glm::dvec3(1);
  scene.tolerance = E;
  const glm::dvec3 middle(-0.5, -0.5, 7.5);
  scene = looking(scene, middle + glm::dvec3(0, 0, distance), middle, width);
  return Session(view_of(scene, medium)).draw(*Gpu::renderer()).image;
}

TEST_F(LitTolerance, FurnaceOfASlab) {
  // L(t) = (E2(t) + E2(D - t)) / 2 at the depth t, seen through e^-t.
  constexpr double K = 0.15, D = 16 * K;
  const auto E2 = [](double t) {
    return integral([&](double mu) { return mu > 0 ? std::exp(-t / mu) : 0.0; });
  };
  const double exact =
      integral([&](double u) { return D * std::exp(-u * D) * (E2(u * D) + E2(D - u * D)) / 2; });
  const Field slab = make_field({{-64, -64, 0}, {63, 63, 15}}, [](glm::ivec3) { return 1.f; });
  constexpr double E = 1e-3;
  const glm::dvec3 albedo(1, 0.5, 0.1);
  const Image image = in_a_furnace(slab, K, E, 8, 60, albedo);
  std::printf("  slab: %.5f, exact %.5f\n", double(pixel(image, 4, 4, 0)), exact);
  for (int c = 0; c < 3; ++c)
    // beside the tolerance: e^-t between voxels, K^2/8, and the slab's end at 64 voxels, e^-9.6
    EXPECT_NEAR(pixel(image, 4, 4, c), albedo[c] * exact, E + exact * K * K / 4 + 1e-4);
  // no shading: the slab is the same everywhere
  EXPECT_NEAR(pixel(image, 0, 0, 0), pixel(image, 4, 4, 0), E);
}

TEST_F(LitTolerance, FurnaceOfABall) {
  // At radius r and the cosine m of a direction's angle with the outward one, light travels
  // sqrt(R^2 - r^2 (1 - m^2)) - r m through the ball.
  constexpr double K = 0.08, R = 20;
  const auto luminance = [&](double r) {
    return integral([&](double u) {
      const double m = 2 * u - 1;
      return std::exp(-K * (std::sqrt(R * R - r * r * (1 - m * m)) - r * m));
    });
  };
  const double exact = 2 * R * K * integral([&](double u) {
                         return std::exp(-K * 2 * R * u) * luminance(std::abs(2 * R * u - R));
                       });
  const glm::dvec3 middle(-0.5, -0.5, 7.5);
  const Field ball = make_field({{-24, -24, -16}, {23, 23, 31}}, [&](glm::ivec3 v) {
    return float(std::clamp(R + 0.5 - glm::length(glm::dvec3(v) - middle), 0.0, 1.0));
  });
  const Image image = in_a_furnace(ball, K, 1e-3, 2, 60);
  std::printf("  ball: %.5f, exact %.5f\n", double(pixel(image, 4, 4, 0)), exact);
  // beside the tolerance: the rim is a voxel wide, which moves the surface by a tenth of one
  EXPECT_NEAR(pixel(image, 4, 4, 0), exact, 1e-3 + 0.1 * K);
}

}  // namespace
}  // namespace psivox
