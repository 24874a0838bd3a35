// Windows over a grid's values: ranges, percentiles, and the curve of the opacity.

#include "psivox/scene.h"
#include "scene/color.h"
#include "scene/transfer_function.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "base/statistics.h"
#include "field/value_range.h"
#include "made_fields.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

/// Values from -2 to 12 over x in 8^3 voxels.
std::shared_ptr<const Field> ramp() {
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) { return float(2 * v.x - 2); });
  field.name = "density";
  return std::make_shared<const Field>(std::move(field));
}

View view_with(std::vector<Setting> settings, std::shared_ptr<const Field> density = ramp()) {
  Scene scene;
  apply_over(scene, settings);
  return make_view(scene, std::move(density), nullptr);
}

TEST(ValuePercentile, IsThatOfSortedValues) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, 100);
  std::vector<float> values;
  for (int i = 0; i < 1001; ++i) values.push_back(i % 7 ? normal(random) : float(i % 3));
  const auto each = [&](const auto& take) {
    for (const float value : values) take(value, 1);
    take(std::numeric_limits<float>::infinity(), 1);
    take(std::numeric_limits<float>::quiet_NaN(), 1);
  };
  const std::vector<double> sorted(values.begin(), values.end());
  for (const double percent : {0.0, 0.1, 1.0, 33.3, 50.0, 99.0, 99.95, 100.0})
    EXPECT_EQ(value_percentile(each, percent), percentile(sorted, percent / 100)) << percent;
  EXPECT_EQ(value_percentile([](const auto&) {}, 50), 0);
}

TEST(ValueWindow, ARangeAloneWindowsTheDensity) {
  const View view = view_with({{"range", "2,6"}, {"extinction", "3"}});
  ASSERT_TRUE(view.medium.transfer);
  const TransferFunction& f = *view.medium.transfer;
  EXPECT_FALSE(f.has_color());
  for (const auto& [value, u] :
       {std::pair(-2.0, 0.0), {2.0, 0.0}, {4.0, 0.5}, {6.0, 1.0}, {12.0, 1.0}})
    EXPECT_NEAR(f.at(value).attenuation, u, 1e-6) << value;
  EXPECT_EQ(view.medium.source, LuminanceSource::constant);
}

TEST(ValueWindow, AColourMapLeavesTheAttenuationToTheValueUnlessACurveSetsIt) {
  const View map = view_with({{"range", "2,6"}, {"colormap", "gray"}});
  EXPECT_NEAR(map.medium.transfer->at(9).attenuation, 9, 1e-6);
  const View curve =
      view_with({{"range", "2,6"}, {"colormap", "gray"}, {"opacity", "0:0,0.5:2,1:1"}});
  const TransferFunction& f = *curve.medium.transfer;
  EXPECT_TRUE(f.has_color());
  for (const auto& [value, factor] :
       {std::pair(2.0, 0.0), {3.0, 1.0}, {4.0, 2.0}, {6.0, 1.0}, {12.0, 1.0}})
    EXPECT_NEAR(f.at(value).attenuation, factor, 1e-6) << value;
  EXPECT_EQ(f.at(6).color, glm::dvec3(1));
  // without a range, over the active values
  EXPECT_EQ(view_with({{"opacity", "0:0,1:1"}}).scene.range, glm::dvec2(-2, 12));
}

TEST(ValueWindow, MaximaGoToWhiteAtTheRangesEnd) {
  for (const char* mode : {"mip", "lmip"}) {
    const View free = view_with({{"mode", mode}});
    EXPECT_EQ(free.scene.range, glm::dvec2(0, 12));
    EXPECT_NEAR(free.medium.transfer->at(12).color.x, 1, 1e-6);
    EXPECT_NEAR(free.medium.transfer->at(3).color.x, 0.25, 1e-6);
    EXPECT_EQ(free.medium.transfer->at(-1).attenuation, 0);  // not seen
    // beyond the range a maximum is brighter than white, and linear
    const View given = view_with({{"mode", mode}, {"range", "-2,3"}});
    for (const double value : {-1.0, 0.0, 3.0, 10.0})
      EXPECT_NEAR(given.medium.transfer->at(value).color.x, (value + 2) / 5, 1e-6) << value;
    EXPECT_GT(given.medium.transfer->at(-1).attenuation, 0);
  }
}

TEST(ValueWindow, PercentilesBecomeNumbersInTheScene) {
  const View view = view_with({{"mode", "mip"}, {"range", "12.5%,75%"}});
  EXPECT_EQ(view.scene.range, glm::dvec2(-2, 8));  // of eight equally frequent values
  const View again = make_view(scene_from_json(to_json(view.scene)), ramp(), nullptr);
  EXPECT_EQ(to_json(again.scene), to_json(view.scene));
  EXPECT_EQ(*again.medium.transfer, *view.medium.transfer);
  EXPECT_THROW(view_with({{"range", "8,50%"}}), Error);
}

/// 10^(x - 3) over x, and one voxel without a logarithm.
std::shared_ptr<const Field> decades() {
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3 v) {
    return v == glm::ivec3(7) ? -5.0f : std::pow(10.0f, float(v.x - 3));
  });
  return std::make_shared<const Field>(std::move(field));
}

TEST(ValueScale, LogarithmsAreTakenAtVoxelsAndOptionsStayInTheFilesValues) {
  const View view = view_with({{"value-scale", "log"}, {"opacity", "0:0,1:1"}}, decades());
  EXPECT_NEAR(view.scene.range->ends.x, 1e-3, 1e-9);
  EXPECT_NEAR(view.scene.range->ends.y, 1e4, 1e-2);
  const Field& field = *view.medium.density;
  EXPECT_EQ(stored_range(field).x, 0);  // the least value above 0, what is below, and vacuum
  EXPECT_NEAR(stored_range(field).y, 7, 1e-6);
  EXPECT_NEAR(view.medium.transfer->at(3.5).attenuation, 0.5, 1e-6);
  const View some =
      view_with({{"value-scale", "log"}, {"colormap", "gray"}, {"range", "0.1,1000"}}, decades());
  EXPECT_EQ(some.scene.range, glm::dvec2(0.1, 1000));
  EXPECT_NEAR(some.medium.transfer->at(4).color.x, colormap_color(Colormap::gray, 0.5).x, 2e-3);
  EXPECT_NEAR(some.medium.transfer->at(4).attenuation, 4, 1e-6);
  const View surface = view_with({{"value-scale", "log"}, {"mode", "isosurface"}}, decades());
  EXPECT_NEAR(surface.scene.isovalue.front().value, std::sqrt(10), 1e-3);  // Otsu's: the middle
  EXPECT_NEAR(surface.medium.surfaces.front().isovalue, 3.5, 1e-4);
  const View again = make_view(scene_from_json(to_json(view.scene)), decades(), nullptr);
  EXPECT_EQ(*again.medium.transfer, *view.medium.transfer);
}

TEST(ValueScale, SymlogKeepsTheSignAndIsLinearNearZero) {
  const View view =
      view_with({{"value-scale", "symlog:0.01"}, {"opacity", "0:1,0.5:0,1:1"}}, decades());
  const ValueScale& scale = view.medium.density->scale;
  EXPECT_NEAR(scale.scaled(-5), -std::log10(501), 1e-12);
  EXPECT_NEAR(scale.scaled(1e-5) / 1e-5, 100 / std::log(10), 0.1);
  for (const double v : {-7.0, -1e-3, 0.0, 1e-8, 3e4})
    EXPECT_NEAR(scale.value_of(scale.scaled(v)), v, 1e-12 * std::abs(v));
  EXPECT_EQ(view_with({{"value-scale", "symlog"}}, decades()).scene.value_scale.unit,
            10);  // of 10^4
}

TEST(ValueScale, PointsOfAFunctionFileAreValuesOfTheFile) {
  const TransferFunction f({{0, 0, {}}, {1e-5, 0.25, {}}, {1, 0.5, {}}, {100, 1, {}}}, false);
  const TransferFunction scaled = scaled_function(f, {ValueScale::Kind::log, 1e-3});
  EXPECT_EQ(scaled.points().size(), 3u);
  EXPECT_EQ(scaled.at(0).attenuation, 0.25);
  EXPECT_NEAR(scaled.at(3).attenuation, 0.5, 1e-6);
  EXPECT_NEAR(scaled.at(4).attenuation, 0.75, 1e-6);
}

TEST(ValueScale, NeedsAValueThatItCanShow) {
  Scene scene;
  apply_over(scene, std::vector<Setting>{{"value-scale", "log"}});
  Field field = make_field({{0, 0, 0}, {7, 7, 7}}, [](glm::ivec3) { return -1.0f; });
  EXPECT_THROW(make_view(scene, std::make_shared<const Field>(field), nullptr), Error);
}

TEST(ValueWindow, AnotherModeOrMapDropsTheRangeThatWasChosenForTheLast) {
  Scene scene = view_with({{"mode", "mip"}}).scene;
  const auto over = [&](std::vector<Setting> settings) {
    Scene changed = scene;
    apply_over(changed, settings);
    return changed;
  };
  EXPECT_EQ(over({{"resolution", "8x8"}}).range, glm::dvec2(0, 12));
  EXPECT_EQ(over({{"mode", "alpha"}}).range, std::nullopt);
  EXPECT_EQ(over({{"mode", "alpha"}, {"range", "1,2"}}).range, glm::dvec2(1, 2));
  EXPECT_EQ(over({{"transfer-function", "f.json"}}).range, std::nullopt);
  scene = view_with({{"opacity", "0:1"}}).scene;
  EXPECT_EQ(over({{"transfer-function", "f.json"}}).opacity, std::nullopt);
  scene.opacity.reset();
  EXPECT_EQ(over({{"luminance", "1,0,0"}}).range, glm::dvec2(-2, 12));
}

}  // namespace
}  // namespace psivox
