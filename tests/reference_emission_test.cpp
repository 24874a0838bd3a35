#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "reference_cases.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

std::shared_ptr<const Field> share(Field field) {
  return std::make_shared<const Field>(std::move(field));
}

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
  const Field density = make_field({{-3, 2, 0}, {10, 12, 9}}, noise, sheared);
  const Field scalar = make_field({{-5, 0, 3}, {6, 16, 12}}, noise,
                                  glm::scale(glm::dmat4(1), glm::dvec3(0.8)) * sheared);
  const Field vector = make_vector_field(
      {{-1, -1, 1}, {16, 15, 12}}, [](glm::ivec3 v) { return glm::vec3(noise(v), 1, noise(-v)); },
      glm::translate(glm::scale(glm::dmat4(1), glm::dvec3(0.7)), {3, 2, 1}) * sheared);
  const glm::dvec3 a(sheared * glm::dvec4(0, 4, 2, 1)), b(sheared * glm::dvec4(7, 10, 7, 1));
  std::vector<Medium> media;
  for (const LuminanceSource source :
       {LuminanceSource::constant, LuminanceSource::density, LuminanceSource::transfer})
    media.push_back(make_medium(density, 1.5, source));
  media.push_back(make_medium(density, 1.5, scalar));
  media.push_back(make_medium(density, 1.5, vector));
  for (Medium& medium : media) {
    medium.color = {1, 0.5, 2};
    if (medium.source == LuminanceSource::transfer)
      medium.transfer = std::make_shared<const TransferFunction>(std::vector<TransferPoint>{
          {0.1, 0, {1, 0, 0}}, {0.3, 1.5, {0.2, 1, 0}}, {0.8, 0.5, {0, 0, 3}}});
    const Emission first{share(scalar), 0.4}, second{share(vector), 0.3};
    for (const auto& emission :
         std::vector<std::vector<Emission>>{{first}, {second}, {first, second}}) {
      medium.emission = emission;
      // the plain quadrature's error with its 48 panels per cell
      for (const WorldRay& ray : rays_through(a, b, 20))
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
