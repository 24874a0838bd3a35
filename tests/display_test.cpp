// How sRGB codes show radiance: exposure, tone map, and what they cannot show.

#include "image/srgb_codes.h"

#include "image_cases.h"

namespace psivox {
namespace {

class DisplayTest : public ImageTest {};

TEST(ToneMap, FilmicIsNarkowiczsCurve) {
  // (x (2.51 x + 0.03)) / (x (2.43 x + 0.59) + 0.14) by hand
  EXPECT_EQ(display_light(0, ToneMap::filmic), 0);
  EXPECT_NEAR(display_light(0.18f, ToneMap::filmic), 0.086724 / 0.324932, 1e-6);
  EXPECT_NEAR(display_light(1, ToneMap::filmic), 2.54 / 3.16, 1e-6);
  EXPECT_LT(display_light(7.2f, ToneMap::filmic), 1);
  EXPECT_GT(display_light(7.3f, ToneMap::filmic), 1);
  EXPECT_NEAR(display_light(inf, ToneMap::filmic), 2.51 / 2.43, 1e-3);
  for (const ToneMap curve : {ToneMap::none, ToneMap::filmic}) {
    EXPECT_EQ(display_light(-1, curve), 0);
    EXPECT_EQ(display_light(nan, curve), 0);
  }
  float last = 0;
  for (float x = 0.001f; x < 10; x *= 1.1f) {
    EXPECT_GT(display_light(x, ToneMap::filmic), last) << x;
    last = display_light(x, ToneMap::filmic);
  }
}

TEST(ToneMap, TheInverseGivesTheRadianceBack) {
  for (const ToneMap curve : {ToneMap::none, ToneMap::filmic})
    for (const double light : {0.01, 0.18, 0.5, 0.95, 1.0}) {
      const auto radiance = static_cast<float>(radiance_of_display(light, curve));
      EXPECT_NEAR(double(display_light(radiance, curve)), light, 1e-6)
          << light;  // float's rounding
    }
}

TEST_F(DisplayTest, CodesAreExposedAndToneMappedAndAlphaIsNot) {
  const Image image = picture(2, 1, {0.5f, 0.1f, 2, 1, 0.25f, 0.05f, 0.5f, 0.5f});
  const WriteOptions options{.display = {1, ToneMap::filmic}};
  const auto code = [](double radiance) {
    const double shown =
        radiance * (2.51 * radiance + 0.03) / (radiance * (2.43 * radiance + 0.59) + 0.14);
    return int(255 * srgb_from_linear(shown) + 0.5);
  };
  write_image(image, file("a.png"), options);
  const std::vector<int> codes = {code(1), code(0.2), code(4), 255,
                                  code(1), code(0.2), code(2), 128};
  EXPECT_EQ(stored_bytes(file("a.png")), codes);
  // linear radiance is left alone
  for (const char* name : {"a.exr", "a.tif"}) {
    write_image(image, file(name), options);
    EXPECT_EQ(largest_difference(read_image(file(name)), image), 0) << name;
  }
}

TEST_F(DisplayTest, BrightPixelsAndLightWithoutOpacityAreCounted) {
  // opaque white; brighter than white; half covered; a glow of 3 at no opacity
  const Image image =
      picture(4, 1, {1, 1, 1, 1, 1.1f, 0, 0, 1, 0.5f, 0.5f, 0.5f, 0.5f, 3, 0.5f, 0, 0});
  const auto count = [&](const char* name, const WriteOptions& options = {}) {
    return clipping(image, name, options);
  };
  const Clipping png = count("a.png");
  EXPECT_EQ(png.clipped, 2u);
  EXPECT_EQ(png.cut, 1u);
  EXPECT_NEAR(png.lost, 1.5 / (3 + 1 + 1.5 + 1.5), 1e-6);
  EXPECT_EQ(count("a.jpg").clipped, 2u);
  EXPECT_EQ(count("a.jpg").cut, 0u);  // over black nothing is cut
  EXPECT_EQ(count("a.exr").clipped, 0u);
  EXPECT_EQ(count("a.tif").clipped, 0u);
  EXPECT_EQ(count("a.tif", {.bits = 16}).clipped, 2u);
  EXPECT_EQ(count("a.png", {.display = {-1, ToneMap::none}}).clipped, 1u);
  EXPECT_EQ(count("a.png", {.display = {0, ToneMap::filmic}}).clipped, 0u);
  EXPECT_EQ(count("a.png", {.display = {2, ToneMap::none}}).clipped, 4u);
}

TEST_F(DisplayTest, AutoExposureClipsAHundredthOfThePixelsAtMost) {
  Image image = noise(100, 100);
  for (float& value : image.rgba()) value = 50 * value * value;
  image.rgba()[0] = inf;  // counts for nothing
  for (const ToneMap curve : {ToneMap::none, ToneMap::filmic}) {
    const double exposure = auto_exposure(image, curve);
    const Clipping dark = clipping(image, "a.jpg", {.display = {exposure, curve}});
    EXPECT_LE(dark.clipped, 100u);
    // a stop more would clip far more
    const Clipping light = clipping(image, "a.jpg", {.display = {exposure + 2, curve}});
    EXPECT_GT(light.clipped, 300u);
  }
  EXPECT_EQ(auto_exposure(picture(1, 1, {0, 0, 0, 0}), ToneMap::none), 0);
  // 0.95 of white, to half a hundredth of a power of two
  EXPECT_NEAR(auto_exposure(picture(1, 1, {0, 9.5f, 0, 1}), ToneMap::none), -std::log2(10), 0.005);
}

}  // namespace
}  // namespace psivox
