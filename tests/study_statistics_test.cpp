// Arithmetic of a study: medians, sums of errors, errors of pictures.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/statistics.h"
#include "psivox/study.h"
#include "study/results.h"

namespace psivox {
namespace {

TEST(Percentile, IsAValueThatTheFractionDoesNotExceed) {
  std::vector<double> hundred;
  for (int i = 100; i >= 1; --i) hundred.push_back(i);
  EXPECT_EQ(percentile(hundred, 0.99), 99);
  EXPECT_EQ(percentile(hundred, 0.991), 100);
  EXPECT_EQ(percentile(hundred, 1), 100);
  EXPECT_EQ(percentile(hundred, 0), 1);
  EXPECT_EQ(percentile({7}, 0.99), 7);
  EXPECT_EQ(percentile({}, 0.99), 0);
}

TEST(Spread, MedianOfOddAndEven) {
  const Spread odd = spread_of({5, 1, 3});
  EXPECT_EQ(odd.median, 3);
  EXPECT_EQ(odd.min, 1);
  EXPECT_EQ(odd.max, 5);
  EXPECT_EQ(odd.lower, 2);
  EXPECT_EQ(odd.upper, 4);
  EXPECT_EQ(spread_of({4, 1, 3, 2}).median, 2.5);
  EXPECT_EQ(spread_of({4, 1, 3, 2}).upper, 3.25);
  EXPECT_EQ(spread_of({7}).lower, 7);
  EXPECT_EQ(spread_of({}).median, 0);
}

TEST(ErrorSum, HasTheMeanTheRmsAndTheFirstLargestMagnitude) {
  ErrorSum sum;
  EXPECT_EQ(sum.rms(), 0);
  EXPECT_EQ(sum.mean(), 0);
  std::size_t at = 10;
  for (const double value : {1.0, -5.0, 5.0, -1.0}) sum.add(value, at++);
  EXPECT_EQ(sum.rms(), std::sqrt(13.0));
  EXPECT_EQ(sum.mean(), 0);
  EXPECT_EQ(sum.max, 5);
  EXPECT_EQ(sum.max_at, 11u);
  ErrorSum earlier;
  earlier.add(-5, 3);
  sum += earlier;
  EXPECT_EQ(sum.max_at, 3u);
  EXPECT_EQ(sum.mean(), -1);
  EXPECT_EQ(sum.rms(), std::sqrt(77.0 / 5));
}

TEST(PictureError, CountsRadianceAndAlphaApart) {
  Image a = rgba_image(4, 3, 0.5f);
  const Image b = rgba_image(4, 3, 0.5f);
  a.rgba()[4 * 6 + 1] += 0.25f;  // G of pixel (2, 1)
  a.rgba()[4 * 9 + 3] -= 0.5f;   // A of pixel (1, 2)
  const PictureError e = picture_error(a, b);
  EXPECT_EQ(e.radiance.max, 0.25);
  EXPECT_EQ(e.radiance.max_x, 2);
  EXPECT_EQ(e.radiance.max_y, 1);
  EXPECT_NEAR(e.radiance.mean, 0.25 / 36, 1e-16);
  EXPECT_NEAR(e.radiance.rms, 0.25 / 6, 1e-16);
  EXPECT_EQ(e.radiance.p99, 0.25);  // the 36th of 36 values
  EXPECT_EQ(e.alpha.max, 0.5);
  EXPECT_EQ(e.alpha.max_x, 1);
  EXPECT_EQ(e.alpha.max_y, 2);
  EXPECT_NEAR(e.alpha.mean, -0.5 / 12, 1e-16);
  EXPECT_NEAR(e.rms(), compare_images(a, b).rms, 1e-16);
}

TEST(PictureError, LeavesOutWhatIsNotFinite) {
  Image a = rgba_image(2, 2, 1);
  a.rgba()[0] = std::numeric_limits<float>::quiet_NaN();
  a.rgba()[7] = std::numeric_limits<float>::infinity();
  const PictureError e = picture_error(a, rgba_image(2, 2, 0));
  EXPECT_EQ(e.radiance.not_finite, 1u);
  EXPECT_EQ(e.alpha.not_finite, 1u);
  EXPECT_EQ(e.radiance.rms, 1);
  EXPECT_EQ(e.alpha.rms, 1);
  EXPECT_THROW(picture_error(a, rgba_image(2, 3, 0)), Error);
}

}  // namespace
}  // namespace psivox
