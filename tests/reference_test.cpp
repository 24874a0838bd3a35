#include "reference/reference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <thread>

#include "made_fields.h"
#include "reference_cases.h"

namespace psivox {
namespace {

TEST(Reference, SlabHasItsClosedForm) {
  // Voxels 0..9 of value 2: nine cells of 2 and a ramp to 0 on each side, 10 in all.
  Medium medium = make_medium(make_field({{0, 0, 0}, {9, 9, 9}}, [](glm::ivec3) { return 2.0f; }),
                              0.05, LuminanceSource::constant);
  medium.color = {1, 2, 3};
  const RayRadiance r = ray_radiance(medium, {{-5, 4.25, 3.5}, {1, 0, 0}});
  EXPECT_NEAR(r.optical_depth, 1.0, 4e-16);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.radiance[c], (c + 1) * (1 - std::exp(-1.0)), 2e-15);
  EXPECT_EQ(r.cells, 11u);
  EXPECT_EQ(ray_radiance(medium, {{-5, 10.5, 3.5}, {1, 0, 0}}).optical_depth, 0);
  EXPECT_EQ(ray_radiance(medium, {{-5, 4, 3}, {-1, 0, 0}}).optical_depth, 0);  // behind the ray
}

TEST(Reference, RampThatGlowsAsItAttenuates) {
  // tau = K x on [0, 8], then falls to 0 on [8, 9]; L = x / 8 of that.
  const double K = 0.125;
  Medium medium = make_medium(
      make_field({{0, 0, 0}, {8, 8, 8}}, [](glm::ivec3 v) { return static_cast<float>(v.x); }), K,
      LuminanceSource::density);
  medium.color = glm::dvec3(0.125);
  auto value = [](double x) { return x < 8 ? x : 8 * (9 - x); };
  const PlainRadiance p =
      plain_radiance([&](double x) { return K * value(x); },
                     [&](double x) { return glm::dvec3(0.125 * value(x)); }, {8.0}, 0, 9, 4000);
  const RayRadiance r = ray_radiance(medium, {{-2, 4, 4}, {1, 0, 0}}, 1e-14);
  EXPECT_NEAR(r.optical_depth, 4.5, 2e-15);
  EXPECT_NEAR(r.radiance.x, p.radiance.x, 1e-13);
  EXPECT_LT(r.error, 1e-13);
}

TEST(Reference, TentOfOneVoxelReachesOneVoxelToEachSide) {
  const Field field = make_field({{0, 0, 0}, {0, 0, 0}}, [](glm::ivec3) { return 3.0f; });
  for (double y : {0.0, 0.25, -0.25, 0.75, -0.999}) {
    for (double z : {0.0, 0.5, -0.5}) {
      const double expected = 0.5 * 3 * (1 - std::abs(y)) * (1 - std::abs(z));
      EXPECT_NEAR(optical_depth(field, 0.5, {{-7, y, z}, {1, 0, 0}}), expected, 1e-15);
      EXPECT_NEAR(optical_depth(field, 0.5, {{y, -7, z}, {0, 1, 0}}), expected, 1e-15);
      EXPECT_NEAR(optical_depth(field, 0.5, {{y, z, 7}, {0, 0, -1}}), expected, 1e-15);
    }
  }
  // Through opposite corners: 2 int_0^1 (1 - u)^3 sqrt(3) du; a face's diagonal works the same.
  EXPECT_NEAR(optical_depth(field, 1, ray_through({-2, -2, -2}, {0, 0, 0})),
              3 * std::numbers::sqrt3 / 2, 2e-15);
  EXPECT_NEAR(optical_depth(field, 1, ray_through({-2, 2, 0}, {0, 0, 0})),
              3 * 2 * std::numbers::sqrt2 / 3, 2e-15);
}

TEST(Reference, AnyAffineTransformAgreesWithPlainQuadrature) {
  const Medium medium = make_medium(sheared_noise(), 1.5, LuminanceSource::density);
  for (const WorldRay& ray : sheared_rays(60))
    expect_equal(ray_radiance(medium, ray), plain(medium, ray, 60), 1e-11);
}

TEST(Reference, CameraInsideSeesOnlyWhatIsAhead) {
  const Medium medium =
      make_medium(make_field({{0, 0, 0}, {15, 15, 15}}, noise), 0.7, LuminanceSource::density);
  for (const glm::dvec3& target : {glm::dvec3(20, 7, 3), {7.5, 7.5, -9}, {7.2, 7.9, 7.4}}) {
    const WorldRay ray = ray_through({7.5, 7.5, 7.25}, target);
    expect_equal(ray_radiance(medium, ray), plain(medium, ray, 60), 1e-11);
  }
  const Field ones = make_field({{0, 0, 0}, {15, 15, 15}}, one);
  EXPECT_NEAR(optical_depth(ones, 1, {{7.5, 7, 7}, {1, 0, 0}}), 8, 1e-15);
  EXPECT_NEAR(optical_depth(ones, 1, {{7.5, 7, 7}, {1, 0, 0}}, 1, 3.5), 2.5, 1e-15);
}

TEST(Reference, FacesEdgesAndCornersAreNeitherLostNorCountedTwice) {
  const Medium medium =
      make_medium(make_field({{-8, -8, -8}, {16, 16, 16}}, noise), 0.3, LuminanceSource::density);
  const glm::dvec3 starts[] = {{0, 0, 0}, {8, 0.5, 8}, {3, 8, 0.25}, {8, 8, 8}, {-8, 1, 8}};
  const glm::dvec3 directions[] = {{1, 0, 0}, {0, -1, 0},  {0, 0, 1},   {1, 1, 0},  {0, 1, -1},
                                   {1, 1, 1}, {-1, 1, -1}, {1, 2, 0.0}, {4, -1, 2}, {1, 1e-17, 0}};
  for (const glm::dvec3& start : starts) {
    for (const glm::dvec3& direction : directions) {
      const WorldRay ray{start - 32.0 * direction, glm::normalize(direction)};
      const WorldRay beside{ray.origin + glm::dvec3(1e-8, -2e-8, 3e-8), ray.direction};
      const RayRadiance r = ray_radiance(medium, ray);
      expect_equal(r, plain(medium, ray, 400), 1e-11);
      // The field's slope is at most 1 per voxel over about 50 voxels; places are off by 6e-8
      // voxels.
      const RayRadiance s = ray_radiance(medium, beside);
      EXPECT_NEAR(r.optical_depth, s.optical_depth, 0.3 * 50 * 6e-8);
    }
  }
  // If every value is 1 the optical depth is the length, whatever the ray meets.
  const Field ones = make_field({{-8, -8, -8}, {16, 16, 16}}, one);
  for (const glm::dvec3& start : starts)
    for (const glm::dvec3& direction : directions)
      EXPECT_NEAR(optical_depth(ones, 1, {0.5 * start, glm::normalize(direction)}, 0, 3.75), 3.75,
                  4e-15);
}

TEST(Reference, TilesEqualVoxels) {
  Field voxels = make_field({{0, 0, 0}, {135, 15, 15}}, [](glm::ivec3 v) {
    return v.x < 128 && v.x >= 120 ? 0.75f : v.x >= 128 ? noise(v) : v.x < 8 ? 0.5f : 0.0f;
  });
  Field tiles = voxels;
  std::erase_if(tiles.leaves, [](const Leaf& leaf) { return leaf.origin.x < 128; });
  for (int y : {0, 8})
    for (int z : {0, 8}) {
      tiles.tiles.push_back({{0, y, z}, 8, glm::vec3(0.5f)});
      tiles.tiles.push_back({{120, y, z}, 8, glm::vec3(0.75f)});
    }
  const Medium a = make_medium(voxels, 0.1, LuminanceSource::density);
  const Medium b = make_medium(tiles, 0.1, LuminanceSource::density);
  for (const WorldRay& ray : rays_through({0, 0, 0}, {136, 16, 16}, 200)) {
    const RayRadiance r = ray_radiance(a, ray), s = ray_radiance(b, ray);
    EXPECT_EQ(r.optical_depth, s.optical_depth);
    EXPECT_EQ(r.radiance.x, s.radiance.x);
    EXPECT_EQ(r.cells, s.cells);
  }
}

TEST(Reference, WideTilesAndEmptySpaceBetween) {
  Field field;
  field.tiles = {{{0, 0, 0}, 128, glm::vec3(1)}, {{1 << 20, 0, 0}, 4096, glm::vec3(2)}};
  field.active_box = {{0, 0, 0}, {(1 << 20) + 4095, 4095, 4095}};
  // 128 and 4096 voxels across, including the ramps at both ends.
  EXPECT_NEAR(optical_depth(field, 1, {{-50, 64, 64}, {1, 0, 0}}), 128 + 2 * 4096, 1e-9);
  EXPECT_NEAR(optical_depth(field, 1, {{-50, 127.5, 64}, {1, 0, 0}}), 64 + 2 * 4096, 1e-9);
  EXPECT_NEAR(optical_depth(field, 1, {{-50, 64, 129}, {1, 0, 0}}), 2 * 4096, 1e-9);
}

TEST(Reference, CountsCellsThatHoldValues) {
  Medium medium = make_medium(
      make_field({{-20, 0, 0}, {40, 7, 7}}, [](glm::ivec3 v) { return v.x == 0 ? 1.0f : 0.0f; }), 1,
      LuminanceSource::constant);
  const RayMedium ready(medium);
  const RayRadiance depth = RayIntegrator(ready, 0).whole_depth({{-50, 3.5, 3.5}, {1, 0, 0}});
  EXPECT_EQ(depth.cells, 2u);  // [-1, 0] and [0, 1]
}

TEST(Reference, PictureIsItsRays) {
  View view;
  view.medium =
      make_medium(make_field({{0, 0, 0}, {15, 15, 15}}, noise), 0.4, LuminanceSource::density);
  view.medium.color = {1, 0.5, 2};
  view.scene.resolution = {21, 13};
  view.camera.position = {7, 8, 30};
  view.camera.target = {7, 8, 0};
  view.camera.right = {1, 0, 0};
  view.camera.up = {0, 1, 0};
  view.camera.forward = {0, 0, -1};
  view.camera.half_width = 0.9;
  view.camera.half_height = 0.9 * 13 / 21;
  for (bool orthographic : {false, true}) {
    view.camera.orthographic = orthographic;
    if (orthographic) view.camera.half_width = 12, view.camera.half_height = 12.0 * 13 / 21;
    for (int n : {1, 3}) {
      view.scene.pixel_samples = n;
      std::vector<double> fractions;
      const std::thread::id here = std::this_thread::get_id();
      const RenderResult result = render_reference(view, 1e-12, [&](double fraction) {
        EXPECT_EQ(std::this_thread::get_id(), here);
        fractions.push_back(fraction);
      });
      EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
      EXPECT_EQ(fractions.back(), 1);

      const Image& image = result.image;
      ASSERT_EQ(image.layers.size(), 2u);
      EXPECT_EQ(image.layers[1].name, "error");
      const RayMedium ready(view.medium);
      RayIntegrator integrator(ready, 1e-12);
      std::uint64_t cells = 0;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          glm::dvec3 radiance(0);
          double A = 0, error = 0;
          for (int i = 0; i < n; ++i) {
            const glm::dvec2 p = pixel_sample(i, n);
            const RayRadiance r = integrator.radiance(
                camera_ray(view.camera, view.scene.resolution, x + p.x, y + p.y));
            radiance += r.radiance / static_cast<double>(n);
            A -= std::expm1(-r.optical_depth) / n;
            error += r.error / n;
            cells += r.cells;
          }
          const auto i = static_cast<std::size_t>(y * image.width + x);
          for (int c = 0; c < 3; ++c)
            EXPECT_FLOAT_EQ(image.rgba()[4 * i + static_cast<std::size_t>(c)],
                            static_cast<float>(radiance[c]));
          EXPECT_FLOAT_EQ(image.rgba()[4 * i + 3], static_cast<float>(A));
          EXPECT_FLOAT_EQ(image.layers[1].values[i], static_cast<float>(error));
        }
      }
      EXPECT_GT(cells, 0u);
      EXPECT_EQ(result.stats.cells, cells);
      const RenderResult again = render_reference(view);
      EXPECT_EQ(again.image.layers[0].values, image.layers[0].values);
      EXPECT_EQ(again.image.layers[1].values, image.layers[1].values);
    }
  }
}

// --- emission ------------------------------------------------------------------------------------

const Box slab{{0, 0, 0}, {9, 9, 9}};

TEST(ReferenceEmission, SlabHasItsClosedForm) {
  // Inside the slab: eps int_0^D e^{-tau s} ds, plus L (1 - e^{-tau D}) from the medium.
  for (const double tau : {1e-9, 0.3, 20.0}) {
    Medium medium = make_medium(make_field(slab, one), tau, LuminanceSource::constant);
    medium.color = {0, 1, 2};
    medium.emission = {{share(make_field(slab, one)), 0.25}};
    const RayMedium ready(medium);
    const RayRadiance r =
        RayIntegrator(ready, 1e-14).radiance({{-5, 4.25, 3.5}, {1, 0, 0}}, 5.5, 12.5);
    const double A = -std::expm1(-7 * tau);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(r.radiance[c], 0.25 * A / tau + medium.color[c] * A, 1e-14 * (2 + 1 / A)) << c;
    EXPECT_LT(r.error, 1e-12);
  }
}

TEST(ReferenceEmission, InVacuumItIsItsIntegral) {
  Medium medium =
      make_medium(make_field({{0, 0, 0}, {3, 3, 3}}, one), 1, LuminanceSource::constant);
  const Field field = make_field({{20, -3, 2}, {33, 10, 12}}, noise, sheared);
  medium.emission = {{share(field), 2.5}};
  const glm::dvec3 a(sheared * glm::dvec4(22, 0, 4, 1)), b(sheared * glm::dvec4(30, 9, 10, 1));
  int seen = 0;
  for (const WorldRay& ray : rays_through(a, b, 60)) {
    const RayRadiance r = ray_radiance(medium, ray);
    if (r.optical_depth > 0) continue;
    const double expected = optical_depth(field, 2.5, ray);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.radiance[c], expected, 1e-14 * (1 + expected));
    seen += expected > 0;
  }
  EXPECT_GT(seen, 30);
}

TEST(ReferenceEmission, EverySourceAgreesWithPlainQuadrature) {
  EverySource every;
  const Emission first{share(every.scalar), 0.4}, second{share(every.vector), 0.3};
  for (Medium& medium : every.media) {
    if (medium.source == LuminanceSource::transfer)
      medium.transfer =
          function({{0.1, 0, {1, 0, 0}}, {0.3, 1.5, {0.2, 1, 0}}, {0.8, 0.5, {0, 0, 3}}});
    for (const auto& emission :
         std::vector<std::vector<Emission>>{{first}, {second}, {first, second}}) {
      medium.emission = emission;
      // the plain quadrature's error with its 48 panels per cell
      for (const WorldRay& ray : sheared_rays(20))
        expect_equal(ray_radiance(medium, ray), plain(medium, ray, 60), 1e-10);
    }
  }
}

TEST(ReferenceEmission, BoundsHold) {
  Medium medium =
      make_medium(make_field({{0, 0, 0}, {15, 15, 15}}, noise), 3, LuminanceSource::density);
  medium.emission = {{share(make_field({{-8, -3, 2}, {24, 20, 13}}, noise))}};
  for (const double scale : {0.1, 100.0}) {
    medium.emission[0].scale = scale;
    for (const WorldRay& ray : rays_through({0, 0, 0}, {15, 15, 15}, 40)) {
      expect_bounded(medium, ray);
      // The tolerance is absolute. About 100 roundings are relative to the emission's bound, which
      // is up to three times the mean of the noise.
      const RayRadiance r = ray_radiance(medium, ray);
      EXPECT_LT(r.error, 2e-12 + 1e-13 * r.radiance.x);
    }
  }
  // two share the tolerance
  medium.emission.push_back({share(make_field({{3, -5, 1}, {20, 30, 9}}, noise)), 7});
  for (const WorldRay& ray : rays_through({0, 0, 0}, {15, 15, 15}, 40)) expect_bounded(medium, ray);
}

}  // namespace
}  // namespace psivox
