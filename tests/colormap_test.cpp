// The built-in colour maps, compared with their published colours, and the functions made from
// them.

#include <gtest/gtest.h>

#include <vector>

#include "scene/color.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

const std::vector<Colormap> every_map = {Colormap::viridis,  Colormap::inferno, Colormap::magma,
                                         Colormap::plasma,   Colormap::cividis, Colormap::turbo,
                                         Colormap::coolwarm, Colormap::gray,    Colormap::hot};

glm::dvec3 code(Colormap map, double u) { return 255.0 * srgb_from_linear(colormap_color(map, u)); }

TEST(Colormap, HasThePublishedColors) {
  struct Known {
    Colormap map;
    int entry;  // index into 256 entries
    glm::dvec3 code;
  };
  // matplotlib's tables in 8 bits; coolwarm: Moreland 2009, ends and middle.
  for (const Known& known : std::vector<Known>{
           {Colormap::viridis, 0, {68, 1, 84}},      {Colormap::viridis, 128, {33, 145, 140}},
           {Colormap::viridis, 255, {253, 231, 37}}, {Colormap::inferno, 0, {0, 0, 4}},
           {Colormap::inferno, 128, {188, 55, 84}},  {Colormap::inferno, 255, {252, 255, 164}},
           {Colormap::magma, 0, {0, 0, 4}},          {Colormap::magma, 128, {183, 55, 121}},
           {Colormap::magma, 255, {252, 253, 191}},  {Colormap::plasma, 0, {13, 8, 135}},
           {Colormap::plasma, 128, {204, 71, 120}},  {Colormap::plasma, 255, {240, 249, 33}},
           {Colormap::cividis, 0, {0, 34, 78}},      {Colormap::cividis, 128, {125, 124, 120}},
           {Colormap::cividis, 255, {254, 232, 56}}, {Colormap::turbo, 0, {48, 18, 59}},
           {Colormap::turbo, 128, {164, 252, 60}},   {Colormap::turbo, 255, {122, 4, 3}},
           {Colormap::coolwarm, 0, {59, 76, 192}},   {Colormap::coolwarm, 255, {180, 4, 38}},
           {Colormap::gray, 0, {0, 0, 0}},           {Colormap::gray, 51, {51, 51, 51}},
           {Colormap::gray, 255, {255, 255, 255}},   {Colormap::hot, 0, {11, 0, 0}},
           {Colormap::hot, 128, {255, 92, 0}},       {Colormap::hot, 255, {255, 255, 255}}}) {
    const glm::dvec3 ours = code(known.map, known.entry / 255.0);
    // Half a step for the published rounding and half a step for the knots'.
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(ours[c], known.code[c], 1)
          << static_cast<int>(known.map) << " " << known.entry << " channel " << c;
  }
  const glm::dvec3 middle = code(Colormap::coolwarm, 0.5);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], 221, 1);
}

TEST(Colormap, IsContinuousWithinTheGamutAndClamped) {
  for (const Colormap map : every_map) {
    glm::dvec3 last = code(map, 0);
    for (int i = 1; i <= 4000; ++i) {
      const glm::dvec3 now = code(map, i / 4000.0);
      for (int c = 0; c < 3; ++c) {
        // The steepest map is turbo: its blue rises by 8 codes per entry at the dark end.
        ASSERT_NEAR(now[c], last[c], 10 * 255 / 4000.0) << static_cast<int>(map) << " " << i;
        ASSERT_GE(now[c], 0);
        ASSERT_LE(now[c], 255 + 1e-9);  // rounding of the encoding
      }
      last = now;
    }
    EXPECT_EQ(colormap_color(map, -3), colormap_color(map, 0));
    EXPECT_EQ(colormap_color(map, 7), colormap_color(map, 1));
  }
}

/// The function of a map over a range, for values from 0 or `least` to `greatest`.
TransferFunction colormap_function(Colormap map, double low, double high, double least,
                                   double greatest) {
  Scene scene;
  scene.colormap = map;
  return window_function(scene, {low, high}, {least, greatest});
}

TEST(ColormapFunction, AttenuatesByTheValueWithinTheData) {
  for (const Colormap map : every_map) {
    const TransferFunction f = colormap_function(map, 0.25, 2, -0.5, 3);
    EXPECT_TRUE(f.has_color());
    for (double v = -0.5; v <= 3; v += 0.01) {
      // Points have float32 values, so the slope between neighbours is 1 within rounding.
      EXPECT_NEAR(f.at(v).attenuation, std::max(v, 0.0), 1e-12) << v;
      // The knots are moved by half a float32 step of 2, 1.2e-7, times a slope of at most 4.
      const glm::dvec3 expected = colormap_color(map, (v - 0.25) / 1.75);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(f.at(v).color[c], expected[c], 1e-6);
    }
    EXPECT_EQ(f.points().front().value, -0.5);
    EXPECT_EQ(f.points().back().value, 3);
    EXPECT_LT(f.points().size(), 80u);
  }
}

TEST(ColormapFunction, LeavesVacuumEmptyAndOmitsKnotsBeyondTheData) {
  const TransferFunction f = colormap_function(Colormap::gray, -10, 10, 2, 2.5);
  EXPECT_EQ(f.at(0).attenuation, 0);
  EXPECT_NEAR(f.at(1).attenuation, 1, 1e-12);
  EXPECT_EQ(f.points().front().value, 0);
  EXPECT_EQ(f.points().back().value, 2.5);
  EXPECT_EQ(colormap_function(Colormap::hot, 0, 1, 0, 0).points().size(), 1u);
  // A range narrower than float32 resolves there gives few distinct points, all in order.
  EXPECT_GE(colormap_function(Colormap::hot, 1000, 1000.00005, 999, 1001).points().size(), 3u);
}

}  // namespace
}  // namespace psivox
