// Differences of two pictures.
#include "image_cases.h"
#include "thrown.h"

namespace psivox {
namespace {

TEST(CompareImages, MeasuresEachChannelAndWhereTheLargestDifferenceIs) {
  Image a = picture(3, 2, std::vector<float>(24, 0.5f));
  const Image b = a;
  a.rgba()[(1 * 3 + 2) * 4 + 1] = 0.25f;   // (2,1) G: -1/4
  a.rgba()[(0 * 3 + 1) * 4 + 3] = 0.625f;  // (1,0) A: +1/8
  const Comparison result = compare_images(a, b);
  EXPECT_DOUBLE_EQ(result.max, 0.25);
  EXPECT_EQ(result.max_x, 2);
  EXPECT_EQ(result.max_y, 1);
  EXPECT_EQ(result.max_channel, "G");
  EXPECT_DOUBLE_EQ(result.rms, std::sqrt((1.0 / 16 + 1.0 / 64) / 24));
  EXPECT_DOUBLE_EQ(result.channel_rms[1], std::sqrt(1.0 / 16 / 6));
  EXPECT_DOUBLE_EQ(result.channel_rms[3], std::sqrt(1.0 / 64 / 6));
  EXPECT_EQ(result.channel_rms[0], 0);
  EXPECT_DOUBLE_EQ(result.channel_mean[1], -0.25 / 6);
  EXPECT_DOUBLE_EQ(result.channel_mean[3], 0.125 / 6);
  EXPECT_EQ(result.not_finite, 0u);
}

TEST(CompareImages, EqualPicturesDifferNowhere) {
  const Image image = noise(5, 5);
  const Comparison result = compare_images(image, image);
  EXPECT_EQ(result.rms, 0);
  EXPECT_EQ(result.max, 0);
  EXPECT_EQ(result.max_channel, "");
}

TEST(CompareImages, CountsPixelsThatAreNotFiniteAndLeavesThemOut) {
  Image a = picture(4, 1, std::vector<float>(16, 1));
  Image b = a;
  a.rgba()[0] = nan;
  a.rgba()[4] = b.rgba()[4] = inf;  // equal in both, but not a finite number
  b.rgba()[11] = -inf;
  b.rgba()[9] = 7;  // in a pixel that is left out
  b.rgba()[12] = 3;
  const Comparison result = compare_images(a, b);
  EXPECT_EQ(result.not_finite, 3u);
  EXPECT_EQ(result.max, 2);
  EXPECT_EQ(result.max_x, 3);
  EXPECT_DOUBLE_EQ(result.rms, 1);  // sqrt(2^2 / (4 channels of 1 pixel))
  EXPECT_DOUBLE_EQ(result.channel_mean[0], -2);

  for (float& value : a.rgba()) value = nan;
  EXPECT_EQ(compare_images(a, b).not_finite, 4u);
  EXPECT_TRUE(std::isnan(compare_images(a, b).rms));  // nothing is known
}

TEST(CompareImages, KeepsSmallDifferencesOfLargeValues) {
  // The squares overflow float, and a float sum of a million of them would lose its last digits.
  const std::size_t pixels = 1 << 18;
  Image a = picture(512, 512, std::vector<float>(pixels * 4, 1e30f));
  Image b = picture(512, 512, std::vector<float>(pixels * 4, 0.0f));
  EXPECT_NEAR(compare_images(a, b).rms / double{1e30f}, 1, 1e-9);
  std::fill(a.rgba().begin(), a.rgba().end(), 1 + 0x1p-23f);
  std::fill(b.rgba().begin(), b.rgba().end(), 1.0f);
  EXPECT_EQ(compare_images(a, b).rms, 0x1p-23);
}

TEST(CompareImages, RefusesDifferentSizes) {
  const std::string text =
      error_of(ExitCode::input, [] { compare_images(noise(4, 2), noise(2, 4)); });
  EXPECT_TRUE(has(text, "4x2"));
  EXPECT_TRUE(has(text, "2x4"));
}

}  // namespace
}  // namespace psivox
