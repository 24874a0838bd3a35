#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "reference_cases.h"

namespace psivox {
namespace {

const Box box{{0, 0, 0}, {20, 15, 17}};
const glm::dvec3 box_min(0, 0, 0), box_max(20, 15, 17);

glm::dvec3 moved(const glm::dmat4& m, const glm::dvec3& p) {
  return glm::dvec3(m * glm::dvec4(p, 1));
}

/// A ray given in a grid's index space, transformed to the world.
WorldRay moved(const glm::dmat4& m, const WorldRay& ray) {
  return ray_through(moved(m, ray.origin), moved(m, ray.origin + 30.0 * ray.direction));
}

TEST(ReferenceLimits, FarOriginsAndScalesChangeNothing) {
  const Medium unit = make_medium(make_field(box, noise), 0.2, LuminanceSource::density);
  struct Case {
    glm::dvec3 origin;
    double scale;
    double ulp;  // of a world coordinate, in voxels: the accuracy of the ray itself
  };
  const Case cases[] = {{{0, 0, 0}, 1e-4, 1e-15},
                        {{0, 0, 0}, 1e4, 1e-15},
                        {{1e6, -1e6, 1e6}, 1, 1e-10},
                        {{1e6, -1e6, 1e6}, 1e4, 1e-14},
                        {{1e6, 1e6, 0}, 1e-4, 1e-6}};
  for (const Case& c : cases) {
    const glm::dmat4 m = glm::scale(glm::translate(glm::dmat4(1), c.origin), glm::dvec3(c.scale));
    const Medium medium =
        make_medium(make_field(box, noise, m), 0.2 / c.scale, LuminanceSource::density);
    for (const WorldRay& ray : rays_through(box_min, box_max, 20)) {
      const RayRadiance a = ray_radiance(unit, ray), b = ray_radiance(medium, moved(m, ray));
      EXPECT_NEAR(a.optical_depth, b.optical_depth, 20 * c.ulp + 1e-13) << c.scale;
      EXPECT_NEAR(a.radiance.x, b.radiance.x, 20 * c.ulp + 1e-12) << c.scale;
    }
  }
}

TEST(ReferenceLimits, FarCamerasAndFarVoxels) {
  // A camera 2^40 voxels away, and the same voxels at indices near 2^30; both are exact in binary.
  auto shifted_noise = [](glm::ivec3 v) { return noise(v - glm::ivec3(1 << 30)); };
  const Box far_box{box.min + (1 << 30), box.max + (1 << 30)};
  const Medium near = make_medium(make_field(box, noise), 0.2, LuminanceSource::density);
  const Medium far =
      make_medium(make_field(far_box, shifted_noise,
                             glm::translate(glm::dmat4(1), glm::dvec3(-double(1 << 30)))),
                  0.2, LuminanceSource::density);
  for (double y : {0.0, 3.3125, 8.0, 14.71875}) {
    const WorldRay ray{{-4, y, 5.3125}, {1, 0, 0}}, away{{-0x1p40, y, 5.3125}, {1, 0, 0}};
    const RayRadiance r = ray_radiance(near, ray);
    EXPECT_GT(r.optical_depth, 0.1);
    EXPECT_NEAR(ray_radiance(near, away).radiance.x, r.radiance.x, 1e-15);
    EXPECT_NEAR(ray_radiance(far, ray).radiance.x, r.radiance.x, 1e-15);
  }
}

TEST(ReferenceLimits, ThinMediaKeepTheirDigits) {
  for (LuminanceSource source : {LuminanceSource::constant, LuminanceSource::density}) {
    const Medium medium = make_medium(make_field(box, noise), 1e-13, source);
    for (const WorldRay& ray : rays_through(box_min, box_max, 20)) {
      const RayRadiance r = ray_radiance(medium, ray);
      const double expected = plain(medium, ray, 150).radiance.x;
      EXPECT_NEAR(r.radiance.x, expected, 1e-11 * expected);
      EXPECT_LE(r.radiance.x, r.optical_depth);
    }
  }
}

TEST(ReferenceLimits, OpaqueMediaShowTheirFace) {
  // On the ramp 0..1 of the first cell tau = K x and L = x: sqrt(pi / (2 K)) if K is large. The
  // constant glow is then 1.
  Field field = make_field(box, one);
  const WorldRay ray{{-4, 5.5, 5.25}, {1, 0, 0}};
  for (double K : {1e2, 1e4, 1e6, 1e9, 1e15, 1e30}) {
    const double expected = std::sqrt(std::numbers::pi / (2 * K));
    const RayRadiance r = ray_radiance(make_medium(field, K, LuminanceSource::density), ray, 1e-13);
    EXPECT_NEAR(r.radiance.x, expected, 2e-13) << K;
    EXPECT_LE(std::abs(r.radiance.x - expected), r.error + 1e-15 * expected) << K;
    EXPECT_EQ(ray_radiance(make_medium(field, K, LuminanceSource::constant), ray).radiance.x,
              -std::expm1(-std::min(K / 2, 700.0)));
  }
  // From inside, where tau does not start at 0: L = 1 at once.
  const RayRadiance inside = ray_radiance(make_medium(field, 1e6, LuminanceSource::density),
                                          {{4.5, 5.5, 5.25}, {1, 0, 0}});
  EXPECT_NEAR(inside.radiance.x, 1, 1e-12);
}

TEST(ReferenceLimits, DenseNoiseAgainstPlainQuadrature) {
  for (double K : {3.0, 30.0, 300.0}) {
    const Medium medium = make_medium(make_field(box, noise), K, LuminanceSource::density);
    for (const WorldRay& ray : rays_through(box_min, box_max, 4)) {
      const RayRadiance r = ray_radiance(medium, ray);
      EXPECT_NEAR(r.radiance.x, plain(medium, ray, 150, 300).radiance.x, 2e-11) << K;
      EXPECT_LT(r.error, 1e-11);
    }
  }
}

TEST(ReferenceLimits, LuminanceGridOfItsOwnTransform) {
  // Coarser, rotated and smaller than the density's domain: rays leave and enter its faces inside
  // the medium, where it still has values.
  glm::dmat4 m =
      glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(4, 5, 6)), 0.5, glm::dvec3(1, 1, 0.3));
  m = glm::scale(m, glm::dvec3(1.7, 1.1, 2.3));
  const Box small{{0, -2, -1}, {6, 4, 4}};
  const Field scalar = make_field(
      small, [](glm::ivec3 v) { return noise(v + 5); }, m);
  const Field vector = make_vector_field(
      small, [](glm::ivec3 v) { return glm::vec3(noise(v + 1), noise(v + 2), 0.5f); }, m);
  for (const Field& luminance : {scalar, vector}) {
    for (const Field& density : {make_field(box, noise), make_field(box, noise, sheared)}) {
      Medium medium = make_medium(density, 0.4, luminance);
      medium.color = {1, 2, 0.5};
      glm::dvec3 a(3, 4, 5), b(12, 10, 14);
      for (const WorldRay& ray : rays_through(a, b, 20))
        expect_equal(ray_radiance(medium, ray), plain(medium, ray, 100), 1e-11);
    }
  }
}

TEST(ReferenceLimits, FurnaceIsOpacity) {
  const Box around{{-9, -9, -9}, {40, 40, 40}};
  const Field glow = make_field(around, one, glm::scale(glm::dmat4(1), glm::dvec3(0.71, 0.9, 1.3)));
  for (double K : {1e-12, 1e-3, 0.3, 5.0, 1e6}) {
    const Medium medium = make_medium(make_field(box, noise), K, glow);
    for (const WorldRay& ray : rays_through(box_min, box_max, 30)) {
      const RayRadiance r = ray_radiance(medium, ray);
      const double A = -std::expm1(-r.optical_depth);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.radiance[c], A, 2e-14 * A);
    }
  }
}

TEST(ReferenceLimits, BoundHolds) {
  const glm::dmat4 m = glm::scale(glm::dmat4(1), glm::dvec3(1.7, 0.6, 2.3));
  const Box around{{-9, -9, -9}, {30, 40, 20}};
  const Medium media[] = {
      make_medium(make_field(box, noise), 0.3, LuminanceSource::density),
      make_medium(make_field(box, noise), 40, LuminanceSource::density),
      make_medium(make_field(box, noise), 3, LuminanceSource::constant),
      make_medium(make_field(box, noise), 2, make_field(around, noise, m)),
      make_medium(make_field(box, noise), 1e3,
                  make_field(
                      around, [](glm::ivec3 v) { return 1e6f * noise(v); }, m))};
  for (Medium medium : media) {
    if (medium.luminance) medium.color = {0, 30, 7};
    const RayMedium ready(medium);
    RayIntegrator fine(ready, 1e-14);
    for (double tolerance : {1e-2, 1e-4, 1e-6, 1e-9, 1e-12, 0.0}) {
      RayIntegrator coarse(ready, tolerance);
      for (const WorldRay& ray : rays_through(box_min, box_max, 100)) {
        const RayRadiance truth = fine.radiance(ray), r = coarse.radiance(ray);
        for (int c = 0; c < 3; ++c)
          EXPECT_LE(std::abs(r.radiance[c] - truth.radiance[c]), r.error + truth.error)
              << tolerance;
        // The rest covers the rounding of radiances up to ready.behind_max.
        EXPECT_LE(r.error, 1.1 * tolerance + 1e-13 * ready.behind_max) << tolerance;
      }
    }
  }
}

}  // namespace
}  // namespace psivox
