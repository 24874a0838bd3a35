// The built-in colour maps, compared with their published colours, and the functions made from
// them.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
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

// --- black bodies --------------------------------------------------------------------------------

/// CIE Y of a colour in Rec. 709's RGB, by the inverse of the matrix in use, from the same
/// primaries.
double luminance(const glm::dvec3& rgb) {
  return 0.2126390059 * rgb.r + 0.7151686788 * rgb.g + 0.0721923154 * rgb.b;
}

/// CIE x, y of a colour in Rec. 709's RGB.
glm::dvec3 chromaticity(const glm::dvec3& c) {
  const glm::dvec3 xyz{0.4123907993 * c.r + 0.3575843394 * c.g + 0.1804807884 * c.b, luminance(c),
                       0.0193308187 * c.r + 0.1191947798 * c.g + 0.9505321522 * c.b};
  return xyz / (xyz.x + xyz.y + xyz.z);
}

/// CIE Y in any unit, by the fit of Wyman, Sloan and Shirley (2013), which is exponential beyond
/// 680 nm. Integrated in steps of 0.25 nm.
double planck_luminance(double kelvin) {
  double sum = 0;
  for (double nm = 360.125; nm < 830; nm += 0.25) {
    const auto lobe = [&](double mean, double below, double above) {
      const double t = (nm - mean) * (nm < mean ? below : above);
      return std::exp(-0.5 * t * t);
    };
    double y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322);
    if (nm > 680) y = 0.004102 * std::exp(-0.0703 * (nm - 700));
    sum += y * std::pow(nm / 1000, -5) / std::expm1(1.438776877e7 / (nm * kelvin));
  }
  return sum;
}

TEST(BlackBody, HasLuminance1At6500K) {
  // The table's row is divided by itself; the two matrices are inverse to ten digits.
  EXPECT_NEAR(luminance(black_body(6500)), 1, 1e-9);
}

TEST(BlackBody, HasThePlanckianLocusChromaticity) {
  // Wyman et al. state RMS errors of their fit of 0.3 % (Y) to 1.4 % (Z) of each function's
  // maximum; 1 % of one tristimulus value moves x or y by up to 0.01 * 1/3 * 2/3 = 0.002. Planckian
  // locus: Wyszecki and Stiles, Color Science, table I(6.2.2) and CIE illuminant A.
  struct Known {
    double kelvin, x, y;
  };
  for (const Known& known : {Known{2856, 0.4476, 0.4074}, Known{4000, 0.3805, 0.3768},
                             Known{6500, 0.3135, 0.3237}, Known{10000, 0.2807, 0.2884}}) {
    const glm::dvec3 xy = chromaticity(black_body(known.kelvin));
    EXPECT_NEAR(xy.x, known.x, 0.002) << known.kelvin;
    EXPECT_NEAR(xy.y, known.y, 0.002) << known.kelvin;
  }
}

TEST(BlackBody, FollowsPlancksLaw) {
  const double white = planck_luminance(6500);
  // 1e-5 for the table's interpolation, 1e-6 for its integration; only where no channel is clamped.
  for (const double kelvin :
       {2000.0, 2500.0, 3000.0, 3017.0, 5000.0, 6500.0, 9000.0, 15000.0, 40000.0})
    EXPECT_NEAR(luminance(black_body(kelvin)) * white / planck_luminance(kelvin), 1, 1.5e-5)
        << kelvin;
  // At high temperatures the Rayleigh-Jeans law holds: proportional to T, less hc/(2 lambda k) =
  // 12800 K.
  EXPECT_NEAR(luminance(black_body(2e7)) / luminance(black_body(1e7)), 2, 2e-3);
}

TEST(BlackBody, IsMonotoneInTemperature) {
  glm::dvec3 last(0);
  for (double kelvin = 201; kelvin < 60000; kelvin *= 1.0007) {
    const glm::dvec3 rgb = black_body(kelvin);
    for (int c = 0; c < 3; ++c) ASSERT_GE(rgb[c], last[c]) << kelvin;
    ASSERT_GT(luminance(rgb), luminance(last)) << kelvin;
    last = rgb;
  }
}

TEST(BlackBody, EndsInSpectralRed) {
  // The colour of 700 nm, x 0.7347, y 0.2653, has no green and no blue in Rec. 709.
  for (double kelvin = 201; kelvin < 800; kelvin += 10) {
    const glm::dvec3 rgb = black_body(kelvin);
    EXPECT_GT(rgb.r, 0) << kelvin;
    EXPECT_LT(rgb.g + rgb.b, 0.02 * rgb.r) << kelvin;
  }
}

TEST(BlackBody, IsDarkAndFiniteAtTheEnds) {
  for (const double kelvin : {-300.0, -0.0, 0.0, 1e-300, 200.0, std::nan("")})
    EXPECT_EQ(black_body(kelvin), glm::dvec3(0)) << kelvin;
  EXPECT_LT(black_body(201).r, std::numeric_limits<float>::min());
  const glm::dvec3 hottest = black_body(1e30);
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(hottest[c]) && hottest[c] > 0);
}

}  // namespace
}  // namespace psivox
