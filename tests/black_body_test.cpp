// The colour of a black body, compared with Planck's law integrated here.

#include "scene/color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace psivox {
namespace {

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
