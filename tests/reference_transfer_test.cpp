#include <gtest/gtest.h>

#include <cmath>

#include "reference_cases.h"

namespace psivox {
namespace {

/// Value x on [0, 8], then falls to 0 on [8, 9].
Field ramp() {
  return make_field({{0, 0, 0}, {8, 8, 8}}, [](glm::ivec3 v) { return static_cast<float>(v.x); });
}
const WorldRay along_x{{-2, 4, 4}, {1, 0, 0}};

/// Peaks, a jump and a plateau over the values of the noise.
const auto peaks = [] {
  return function({{0.05, 0, {1, 0, 0}},
                   {0.2, 1.5, {0.2, 1, 0}},
                   {0.25, 0.1, {0, 0, 3}},
                   {0.5, 0.1, {1, 1, 1}},
                   {0.5, 2, {0, 0.5, 1}},
                   {0.8, 0, {0.3, 0.2, 0.1}}});
};
const auto jump = [] { return function({{0.4, 0, {0, 0, 1}}, {0.4, 1, {1, 0.5, 0}}}); };

TEST(ReferenceTransfer, RampUnderATentHasItsClosedForm) {
  Medium medium = make_medium(ramp(), 0.7, LuminanceSource::constant);
  medium.transfer = function({{2, 0, {}}, {4, 1, {}}, {6, 0, {}}});
  const RayRadiance r = ray_radiance(medium, along_x);
  // The tent's area is 2 on the rise and an eighth of that on the fall.
  EXPECT_NEAR(r.optical_depth, 0.7 * 2 * 1.125, 1e-15);
  EXPECT_NEAR(r.radiance.x, 1 - std::exp(-0.7 * 2 * 1.125), 1e-15);
  EXPECT_LT(r.error, 1e-13);
}

TEST(ReferenceTransfer, LinearColourBetweenJumpsHasItsClosedForm) {
  // Attenuation 1 and L = (v - 2) / 4 for v from 2 to 6, else vacuum.
  const double K = 0.6;
  Medium medium = make_medium(ramp(), K, LuminanceSource::transfer);
  medium.color = {1, 2, 0.5};
  medium.transfer = function(
      {{2, 0, glm::dvec3(0)}, {2, 1, glm::dvec3(0)}, {6, 1, glm::dvec3(1)}, {6, 0, glm::dvec3(1)}});
  const RayRadiance r = ray_radiance(medium, along_x);
  // A jump's ramp starts at its value and ends one float32 later: at 2 half of it is lost, at 6
  // half is gained.
  const double edges =
      0.5 * (std::nextafter(6.0f, 7.0f) - 6.0f) - 0.5 * (std::nextafter(2.0f, 7.0f) - 2.0f);
  EXPECT_NEAR(r.optical_depth, K * (4 + edges) * 1.125, 1e-14);
  // Rise: int_0^4 s/4 K e^{-K s} ds; fall, at 8 per voxel: its mirror image.
  const double D = 4 * K, d = D / 8;
  const double up = (1 - std::exp(-D) * (1 + D)) / D;
  const double down = 1 - (1 - std::exp(-d)) / d;
  // The jumps' ramps shift the ends by at most 2.4e-7 voxels.
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(r.radiance[c], medium.color[c] * (up + std::exp(-D) * down), 3e-7) << c;
}

TEST(ReferenceTransfer, AJumpCutsWhereTheValuePassesIt) {
  Medium medium = make_medium(ramp(), 0.25, LuminanceSource::constant);
  medium.transfer = function({{3.25, 0, {}}, {3.25, 1, {}}});
  // The jump ends at the next float32, 2.4e-7 above 3.25; half of its ramp is lost.
  const double lost = 0.5 * (std::nextafter(3.25f, 4.0f) - 3.25f);
  const double length = (8 - 3.25 - lost) * 1.125;
  EXPECT_NEAR(ray_radiance(medium, along_x).optical_depth, 0.25 * length, 1e-14);
  // The depth that xray shows ends there too.
  const RayMedium ready(medium);
  const RayRadiance depth = RayIntegrator(ready, 1e-12).whole_depth(along_x);
  EXPECT_NEAR(depth.optical_depth, 0.25 * length, 1e-14);
  EXPECT_LT(depth.error, 1e-13);
}

TEST(ReferenceTransfer, AConstantValueOnAJumpIsItsLowerEnd) {
  // The ramps at the ends of the slab are below the jump, so nothing attenuates. One float32
  // higher, everything does.
  const float v = 0.3f;
  for (const float above : {0.0f, 1.0f}) {
    const float value = above > 0 ? std::nextafter(v, 1.0f) : v;
    Medium medium =
        make_medium(make_field({{0, 0, 0}, {9, 9, 9}}, [=](glm::ivec3) { return value; }), 0.1,
                    LuminanceSource::constant);
    medium.transfer = function({{v, 0, {}}, {v, 1, {}}});
    const RayRadiance r = ray_radiance(medium, {{-5, 4.25, 3.5}, {1, 0, 0}});
    // the slab of 9, and the last float32 step of each ramp from 0, which is 1e-7 of it
    EXPECT_NEAR(r.optical_depth, 0.1 * 9 * above, 2e-8);
    EXPECT_LT(r.error, 1e-13);
  }
}

TEST(ReferenceTransfer, TheValueItselfAsAFunctionIsThePlainPath) {
  for (const LuminanceSource source : {LuminanceSource::constant, LuminanceSource::density}) {
    Medium medium = make_medium(sheared_noise(), 1.5, source);
    medium.color = {1, 2, 0.5};
    Medium by_function = medium;
    by_function.transfer = function({{0, 0, {}}, {0.25, 0.25, {}}, {2, 2, {}}});
    for (const WorldRay& ray : sheared_rays(60)) {
      const RayRadiance r = ray_radiance(medium, ray), s = ray_radiance(by_function, ray);
      EXPECT_NEAR(r.optical_depth, s.optical_depth, 1e-13);
      EXPECT_EQ(r.cells, s.cells);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(r.radiance[c], s.radiance[c], r.error + s.error);
    }
  }
}

TEST(ReferenceTransfer, EverySourceAgreesWithPlainQuadrature) {
  EverySource every;
  for (Medium& medium : every.media)
    for (const auto& transfer : {peaks(), jump()}) {
      medium.transfer = transfer;
      // The plain quadrature bisects crossings in t to 1e-15 of a ray's length of about 50: 1e-6 of
      // a jump's ramp, which is 1e-7 of a cell. It misses a value that crosses and returns within
      // 1/32 of a cell, which happens at no jump of these rays.
      for (const WorldRay& ray : sheared_rays(25))
        expect_equal(ray_radiance(medium, ray), plain(medium, ray, 60), 1e-9);
    }
}

TEST(ReferenceTransfer, ZeroMayAttenuateInTheWholeDomain) {
  // One voxel is 1 in a domain of 60 x 12 x 12, in which only one leaf holds values.
  Field field = make_field({{0, 0, 0}, {7, 7, 7}},
                           [](glm::ivec3 v) { return v == glm::ivec3(3, 3, 3) ? 1.0f : 0.0f; });
  field.active_box = {{-20, -2, -2}, {37, 9, 9}};
  Medium medium = make_medium(field, 0.1, LuminanceSource::transfer);
  medium.transfer = function({{0, 0.5, {1, 1, 1}}, {1, 2, {0, 1, 0.5}}});
  // 59 voxels of 1/2, and 2 of a triangle from 1/2 to 2 through the voxel.
  const RayRadiance beside = ray_radiance(medium, {{-50, 8.5, 8.25}, {1, 0, 0}});
  EXPECT_NEAR(beside.optical_depth, 0.1 * 0.5 * 59, 1e-14);
  EXPECT_NEAR(beside.radiance.x, 1 - std::exp(-0.1 * 0.5 * 59), 1e-14);
  EXPECT_EQ(beside.cells, 0u);
  EXPECT_NEAR(ray_radiance(medium, {{-50, 3, 3}, {1, 0, 0}}).optical_depth, 0.1 * (0.5 * 59 + 1.5),
              1e-14);
  // From inside; outside the domain there is nothing.
  EXPECT_NEAR(ray_radiance(medium, {{20.5, 8.5, 8}, {1, 0, 0}}).optical_depth, 0.1 * 0.5 * 17.5,
              1e-14);
  EXPECT_EQ(ray_radiance(medium, {{-50, 10.5, 8}, {1, 0, 0}}).optical_depth, 0);
  for (const WorldRay& ray : rays_through({-19, -1, -1}, {37, 9, 9}, 40))
    expect_equal(ray_radiance(medium, ray), plain(medium, ray, 300), 1e-11);
  // Tables of cubes 128 and 4096 wide.
  field.active_box = {{-10000, -10000, -10000}, {20000, 20000, 20000}};
  medium = make_medium(field, 1e-5, LuminanceSource::constant);
  medium.transfer = function({{0, 0.5, {}}, {1, 0.5, {}}});
  EXPECT_NEAR(ray_radiance(medium, {{-50000, 3, 3}, {1, 0, 0}}).optical_depth, 0.5e-5 * 30002,
              1e-14);
}

TEST(ReferenceTransfer, BoundsHold) {
  for (const LuminanceSource source : {LuminanceSource::density, LuminanceSource::transfer}) {
    Medium medium = make_medium(make_field({{0, 0, 0}, {15, 15, 15}}, noise), 3, source);
    medium.color = {1, 0.5, 4};
    for (const auto& transfer : {peaks(), jump()}) {
      medium.transfer = transfer;
      for (const WorldRay& ray : rays_through({0, 0, 0}, {15, 15, 15}, 30))
        expect_bounded(medium, ray);
      // a jump of 1 over 3e-8, in values accurate to 1e-15, each crossed within 1e-7 of a cell
      EXPECT_LT(ray_radiance(medium, along_x).error, 1e-10);
    }
  }
}

}  // namespace
}  // namespace psivox
