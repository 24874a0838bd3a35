// The GPU's pictures of fields with known integrals, and the furnace: constant L gives exactly L (1
// - T) for any attenuation, rule, step and camera.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "march_cases.h"
#include "verify/case.h"

namespace psivox {
namespace {

class MarchAnalytic : public GpuTest {};
class Furnace : public GpuTest {};

template <typename Depth>
void expect_opacity(const std::string& what, const View& view, Depth depth,
                    double tolerance = 1e-6) {
  const Image image = gl_picture(view);
  expect_content(image, 1e-4);
  const double worst = opacity_error(view, image, depth);
  std::printf("  %-32s %.2e\n", what.c_str(), worst);
  testing::Test::RecordProperty(what, std::to_string(worst));
  EXPECT_LE(worst, tolerance) << what;
}

/// A plate so wide that every ray of the picture enters and leaves through its x faces.
void expect_plate(const char* what, const Plate& plate, double K) {
  const auto depth = [&](const WorldRay& ray) { return K * plate.along(ray); };
  Scene scene = small_scene();
  scene.extinction = K;
  scene.luminance = {1, 2, 0.5};
  const auto shared = share(plate.field());
  for (const double side : {-1.0, 1.0}) {
    const glm::dvec3 middle(0.5 * double(plate.values.size()), 0.3, -0.2);
    Scene perspective = looking(scene, middle + glm::dvec3(side * 40, 3, 2), middle);
    perspective.fov = 30;
    expect_opacity(std::string(what) + " perspective", view_of(perspective, shared), depth);
    expect_opacity(
        std::string(what) + " orthographic",
        view_of(looking(scene, middle + glm::dvec3(side * 40, 7, -5), middle, 20.0), shared),
        depth);
    expect_opacity(
        std::string(what) + " along x",
        view_of(looking(scene, middle + glm::dvec3(side * 40, 0, 0), middle, 20.0), shared), depth);
  }
}

TEST_F(MarchAnalytic, Slab) {
  expect_plate("slab", {profile(12, [](int) { return 2; })}, 0.05);
  expect_plate("thick slab", {profile(40, [](int) { return 0.5; })}, 0.04);
}

TEST_F(MarchAnalytic, LinearRamp) {
  expect_plate("ramp", {profile(17, [](int x) { return 0.125 * x; })}, 0.05);
}

TEST_F(MarchAnalytic, SingleVoxelsTent) {
  const auto field = share(make_field({{8, 0, -8}, {8, 0, -8}}, [](glm::ivec3) { return 1.5f; }));
  Scene scene = small_scene(33);  // the middle pixel's ray goes through the voxel's centre
  scene.extinction = 0.9;
  const auto depth = [](const WorldRay& ray) { return 1.35 * tent_along(ray, {8, 0, -8}); };
  const glm::dvec3 voxel(8, 0, -8);
  for (const glm::dvec3& from : {glm::dvec3(20, 0, 0), {0, -20, 0}, {0, 0, 20}, {12, 9, 7}}) {
    scene.camera_up = from.y == -20 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    expect_opacity("tent orthographic", view_of(looking(scene, voxel + from, voxel, 2.2), field),
                   depth);
    Scene perspective = looking(scene, voxel + from, voxel);
    perspective.fov = 8;
    expect_opacity("tent perspective", view_of(perspective, field), depth);
  }
  // Straight along x through the middle: K v; at (y, z) from it: K v (1 - |y|)(1 - |z|).
  const View view = view_of(looking(scene, voxel + glm::dvec3(20, 0, 0), voxel, 2.0), field);
  const Image image = gl_picture(view);
  EXPECT_NEAR(pixel(image, 16, 16, 3), -std::expm1(-1.35), 1e-6);
  for (const glm::ivec2 at : {glm::ivec2(3, 16), glm::ivec2(20, 9), glm::ivec2(30, 30)}) {
    const glm::dvec2 offset = glm::abs(2.0 * (glm::dvec2(at) + 0.5) / 33.0 - 1.0);
    EXPECT_NEAR(pixel(image, at.x, at.y, 3), -std::expm1(-1.35 * (1 - offset.x) * (1 - offset.y)),
                1e-6);
  }
}

TEST_F(MarchAnalytic, LinearLuminanceInHomogeneousMedium) {
  // tau is constant, so Psi = h(x) exactly, and psi-weighted is exact for linear L. L = (x - 2)/4
  // from x = 2 on, inside a plate so opaque that its back is invisible: R = e^{-d} / (4 tau), where
  // d is the depth in front of x = 2, half a cell's ramp and two cells.
  const double tau = 0.5;
  const Field plate = make_field({{0, -20, -20}, {63, 20, 20}}, [](glm::ivec3) { return 1.0f; });
  const Field L = make_field({{0, -24, -24}, {66, 24, 24}},
                             [](glm::ivec3 v) { return std::max(0.0f, 0.25f * float(v.x - 2)); });
  Scene scene = small_scene(24);
  scene.extinction = tau;
  Scene oblique = looking(scene, {-40, 5, 4}, {4, 0, 0}, 10.0);
  Scene perspective = looking(scene, {-20, 2, 3}, {4, 0, 0});
  perspective.fov = 25;
  for (const Scene& s : {oblique, perspective}) {
    const View view = view_of(s, plate, L);
    ASSERT_EQ(view.medium.source, LuminanceSource::scalar);
    const Image image = gl_picture(view);
    double worst = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const double cosine = pixel_ray(view, x, y).direction.x;
        const double exact = 0.25 * cosine / tau * std::exp(-tau * 2.5 / cosine);
        worst = std::max(worst, std::abs(pixel(image, x, y, 0) - exact));
      }
    std::printf("  linear luminance: %.2e\n", worst);
    EXPECT_LE(worst, 1e-6);
  }
}

// --- furnace -------------------------------------------------------------------------------------

double worst_of_furnace(const Image& image) {
  double worst = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c)
        worst = std::max(worst, double(std::abs(pixel(image, x, y, c) - pixel(image, x, y, 3))));
  return worst;
}

struct FurnaceCamera {
  const char* name;
  glm::dvec3 position;
};
const FurnaceCamera furnace_cameras[] = {{"outside", {90, 60, 75}}, {"inside", {12.3, 9.1, 10.7}}};

void furnace(const View& view, const std::string& what, double& worst) {
  const Image image = gl_picture(view);
  expect_content(image);
  const double seen = worst_of_furnace(image);
  EXPECT_LE(seen, 1e-6) << what;
  worst = std::max(worst, seen);
}

void furnace_of(Integrator rule) {
  const auto density = share(mixed()), ones = share(ones_around_mixed());
  for (const auto& [name, position] : furnace_cameras) {
    double constant = 0, weights = 0;
    for (const double step : {0.0, 0.1, 0.73, 1.0, 3.7, 16.0}) {
      if (is_transfer_rule(rule) || (step > 0 && is_cell_rule(rule))) continue;
      Scene scene = looking(small_scene(32), position, {11, 12, 8});
      scene.extinction = 0.15;
      scene.early_termination = Scene{}.early_termination;
      scene = with(scene, rule, step > 0 ? std::optional(step) : std::nullopt);
      const std::string what = std::string(name) + " step " + std::to_string(step);
      furnace(view_of(scene, density), what + " constant L", constant);
      furnace(make_view(scene, density, ones), what + " grid of 1", weights);
    }
    std::printf("  %-16s %-8s |R - A| constant L %.2e, grid of 1 %.2e\n", info(rule).name, name,
                constant, weights);
  }
}

#define PSIVOX_ROW(name, middle, exact, cost, help) \
  TEST_F(Furnace, name) { furnace_of(Integrator::name); }
PSIVOX_INTEGRATORS(PSIVOX_ROW)
#undef PSIVOX_ROW

TEST_F(MarchAnalytic, Walls) {
  // Attenuation and L rise from 0 within one voxel, up to a million optical depths. Nothing goes
  // through, and R = sqrt(pi / (2 K)), the integral of x K x e^{-K x^2/2}. Rules of linear segments
  // see a front segment of the ramp as a whole: their result only has to lie between its L and 0.
  const auto wall =
      share(make_field({{1, -20, -20}, {12, 20, 20}}, [](glm::ivec3) { return 1.0f; }));
  for (const double K : {1e2, 1e4, 1e6})
    for (const IntegratorInfo& rule : integrators) {
      if (is_transfer_rule(rule.id)) continue;
      Scene scene = looking(small_scene(4), {-10, 0.3, 0.2}, {0, 0.3, 0.2}, 4.0);
      scene.extinction = K;
      scene.integrator = rule.id;
      const Image image = gl_picture(view_of(scene, wall, Glow::density));
      const double expected = std::sqrt(std::numbers::pi / (2 * K));
      std::printf("  K %g %s: A %.7f R %.3e (exact %.3e)\n", K, rule.name, pixel(image, 1, 1, 3),
                  pixel(image, 1, 1, 0), expected);
      EXPECT_NEAR(pixel(image, 1, 1, 3), 1, 1e-6) << rule.name << ' ' << K;
      EXPECT_GE(pixel(image, 1, 1, 0), 0) << rule.name << ' ' << K;
      EXPECT_LE(pixel(image, 1, 1, 0), 1) << rule.name << ' ' << K;
      if (is_cell_rule(rule.id)) {
        EXPECT_NEAR(pixel(image, 1, 1, 0) / expected, 1, 1e-3) << K;
      }
    }
}

}  // namespace
}  // namespace psivox
