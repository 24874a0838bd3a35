// A study's pictures of other renderers, its clocks and its forecast.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/text.h"
#include "psivox/parameters.h"
#include "study/study_pictures.h"
#include "thrown.h"

namespace psivox {
namespace {

StudyResults two_points() {
  StudyResults results;
  results.scene = to_json(Scene{});
  for (const double step : {1.0, 0.5}) {
    StudyPoint point;
    point.variant.method = {Integrator::midpoint, Sampling::uniform, 0, step};
    point.error.radiance.rms = point.error.alpha.rms = 1e-3 * step;
    results.points.push_back(point);
  }
  return results;
}

TEST(Foreign, TextsName) {
  const ForeignPicture timed = foreign_picture("cycles 1=a=b,c.exr,12.5");
  EXPECT_EQ(timed.name, "cycles 1");
  EXPECT_EQ(timed.file, "a=b,c.exr");
  EXPECT_EQ(timed.time_ms, 12.5);
  EXPECT_EQ(file_name(timed), "foreign_cycles_1");
  EXPECT_EQ(foreign_picture("x=a,b").file, "a,b");
  for (const char* text : {"", "a", "a=", "a,b"})
    EXPECT_NE(usage_error([&] { foreign_picture(text); }), "no error") << text;
  StudyOptions options;
  for (const char* text : {"=a", "a,b=c", " a=b", "a =b", "psivox=b", "a=b,-1", "a=b,inf"}) {
    options.foreign = {foreign_picture(text)};
    EXPECT_NE(usage_error([&] { check_foreign(options, Scene{}); }), "no error") << text;
  }
}

TEST(Foreign, PicturesWithNaNAreRefused) {
  StudyOptions options;
  options.foreign = {{"peer", testing::TempDir() + "foreign.exr"}};
  Scene scene;
  scene.resolution = {2, 1};
  Image image{2, 1, {{"", {"R", "G", "B", "A"}, {0, 0, 0, 0, 0, 1, 0, 1}}}, {}};
  write_image(image, options.foreign[0].file);
  check_foreign(options, scene);
  image.rgba()[3] = NAN;
  write_image(image, options.foreign[0].file);
  EXPECT_THROW(check_foreign(options, scene), Error);
}

TEST(Foreign, AnOpaquePictureIsComparedOverTheBackground) {
  const Image reference{2, 1, {{"", {"R", "G", "B", "A"}, {0.5, 0, 0, 0.5, 0, 0, 0, 0}}}, {}};
  const Image picture{2, 1, {{"", {"R", "G", "B", "A"}, {0.75, 0, 0, 1, 0.5, 0, 0.5, 1}}}, {}};
  const ForeignPoint point =
      compare_foreign({"peer", "file"}, picture, reference, {0.5, 0, 0}, {}).point;
  EXPECT_TRUE(point.opaque);
  EXPECT_EQ(point.error.radiance.max, 0.5);  // of the second pixel's blue
  EXPECT_EQ(point.rms(), std::sqrt(0.25 / 6));
}

TEST(Results, ForeignPointsAreKept) {
  StudyResults r = two_points();
  r.foreign.push_back(
      {.picture = {"peer 2", "a.exr", 3.5}, .opaque = true, .resolution = {32, 24}});
  r.foreign[0].error.radiance.rms = 0.25;
  r.foreign.push_back({.picture = {"peer 3", "b.exr"}});
  const StudyResults read = results_from_json(results_json(r), "a study");
  ASSERT_EQ(read.foreign.size(), 2U);
  EXPECT_EQ(read.foreign[0].picture.time_ms, 3.5);
  EXPECT_EQ(read.foreign[0].rms(), 0.25);
  EXPECT_EQ(read.foreign[0].resolution, glm::ivec2(32, 24));
  EXPECT_EQ(read.foreign[1].picture.time_ms, 0);
  EXPECT_FALSE(read.foreign[1].opaque);
  std::set<std::ptrdiff_t> commas;
  for (const std::string& line : psivox::split(results_csv(r), '\n'))
    commas.insert(std::ranges::count(line, ','));
  EXPECT_EQ(commas.size(), 1U) << results_csv(r);
}

TEST(Clocks, ProcessorTimeAloneWhereOtherWorkDisturbsWallTime) {
  StudyResults r = two_points();
  r.renderer = "llvmpipe (LLVM 15)";
  for (StudyPoint& point : r.points) point.times = {{10, 10, 20}, {14, 14, 20.5}, {30, 30, 21}};
  EXPECT_TRUE(has(clock_note(r), "wall times scatter by 71 %"));
  EXPECT_TRUE(has(results_json(r), "wall times scatter by 71 %"));
  r.renderer = "a GPU";  // its work is not the processor's
  EXPECT_EQ(clock_note(r), "");
}

TEST(StudyCost, ForecastsFromATrial) {
  StudyOptions options;
  Scene scene;
  scene.resolution = {1280, 720};
  StudyPlan plan;
  plan.variants.push_back(two_points().points[0].variant);
  StudyCost cost(options, plan, scene);
  // the reference's 60 s, 2 pictures to measure and 3 to time of 1 s, a march of 10 s, 2 programs
  const CostTrial trial{.gpu = 1, .compile = 0.25, .march = 10, .reference = 60};
  EXPECT_EQ(cost.forecast(plan.variants[0], trial),
            "the study takes about 76 seconds, by a trial; for less: --resolution 640x360 (19 "
            "seconds), --no-split (66 seconds), fewer --integrators or --steps");
  EXPECT_EQ(cost.forecast(plan.variants[0], {.gpu = 1, .compile = 0, .march = 1, .reference = 1}),
            "");
}

}  // namespace
}  // namespace psivox
