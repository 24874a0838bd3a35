#include <gtest/gtest.h>

#include <cmath>

#include "made_fields.h"
#include "reference_cases.h"

namespace psivox {
namespace {

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
