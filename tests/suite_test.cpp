// What the precision suite holds. tests/suite_test.sh runs it.

#include "study/suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "made_fields.h"
#include "psivox/draw.h"
#include "suite_truths.h"

namespace psivox {
namespace {

SuiteRow exact_row(double error) {
  SuiteRow row;
  row.point.variant.method.integrator = Integrator::cell_exact;
  row.point.error.radiance.rms = row.point.error.alpha.rms = row.max = error;
  return row;
}

/// Errors that fall by the order `observed`, at so many steps.
OrderRow order_row(double expected, double observed, int points) {
  OrderRow row{.scene = "scene", .way = "midpoint uniform", .expected = expected};
  for (int i = 0; i < points; ++i) row.errors.emplace_back(std::exp2(-i), std::exp2(-observed * i));
  return row;
}

TEST(Suite, SaysWhatMisses) {
  SuiteResult result;
  result.scene.name = "scene";
  result.orders = {order_row(2, 1.8, 4), order_row(0, 0.5, 4), order_row(2, 0, 2)};
  result.rows = {exact_row(1e-6)};
  EXPECT_TRUE(result.misses().empty());
  result.orders.push_back(order_row(2, 1.5, 4));
  result.rows.push_back(exact_row(3e-6));
  result.faults = 1;
  EXPECT_EQ(result.misses().size(), 3u);
  EXPECT_EQ(result.misses().front(), "scene: midpoint uniform has order 1.50, expected 2");
}

// Where a closed form is known, the reference is within its own bound of it. Pictures hold floats:
// a half unit in the last place of numbers below 1, for the picture and for its voxels each.
TEST(Suite, ClosedFormsConfirmTheReference) {
  const std::map<std::string, SuiteTruth> truths = suite_truths();
  const auto reference = open_reference();
  std::size_t found = 0;
  for (const SuiteScene& scene : suite_scenes(false, testing::TempDir())) {
    const auto truth = truths.find(scene.name);
    if (truth == truths.end()) continue;
    ++found;
    Wish wish;
    wish.layers.error = true;
    Session session(scene.views.front());
    const Image image = session.draw(*reference, wish).image;
    const auto& bounds = image.layers.back().values;
    const double bound = *std::ranges::max_element(bounds) + 2 * 0x1p-24;
    for_pixels(scene.views.front(), image, [&](const WorldRay& ray, const float* rgba) {
      EXPECT_NEAR(rgba[truth->second.channel], truth->second.value(ray), bound) << scene.name;
    });
  }
  EXPECT_EQ(found, truths.size());
}

}  // namespace
}  // namespace psivox
