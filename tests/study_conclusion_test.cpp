// What a study concludes from its points, and which settings reach an error.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "psivox/parameters.h"
#include "study/conclusion.h"
#include "thrown.h"

namespace psivox {
namespace {

/// A point with one error for all its values.
StudyPoint point_of(const Variant& variant, double error, double samples, double cpu_ms) {
  StudyPoint p;
  p.variant = variant;
  p.error.radiance.rms = p.error.alpha.rms = error;
  p.error.radiance.p99 = p.error.alpha.p99 = 3 * error;
  p.samples_per_ray = samples;
  p.times = {{cpu_ms, cpu_ms, cpu_ms}};
  return p;
}

TEST(Conclusion, NamesTheCheapestForEightBitsAndForSmallErrors) {
  const Variant porter{{Integrator::porter_duff, Sampling::uniform, 0, 2}},
      balanced{{Integrator::psi_balanced, Sampling::uniform, 0, 2}},
      fine{{Integrator::psi_balanced, Sampling::uniform, 0, 1}},
      exact{{Integrator::cell_exact, Sampling::cells, 0, 0}};
  StudyResults r;
  r.scene = to_json(Scene{});
  // 3 * 7e-4 is above 1/510, 3 * 4e-4 below
  r.points = {point_of(porter, 7e-4, 37, 1), point_of(balanced, 4e-4, 38, 2),
              point_of(fine, 2e-4, 76, 3), point_of(exact, 5e-6, 60, 4)};
  EXPECT_EQ(conclusion_text(r),
            "For 8 bits use `--step 2 --integrator psi-balanced`: RMS 4.0e-4, 38 look-ups a ray; "
            "for an RMS of 1e-4 or less use `--integrator cell-exact`: 60 look-ups a ray.");
  EXPECT_EQ(conclusion_of(r).fine_rms, 1e-4);
  const std::string json = results_json(r);
  EXPECT_TRUE(has(json, conclusion_text(r)));
  EXPECT_TRUE(has(json, "\"from_rms\": 0.0001"));

  // Hardly more look-ups and less time wins; many more look-ups and less time does not.
  r.points.push_back(point_of({{Integrator::midpoint, Sampling::uniform, 0, 2}}, 4e-4, 39, 1));
  EXPECT_EQ(conclusion_of(r).eight_bits, &r.points[4]);
  // Where times hardly differ, the least error wins.
  r.points[1].times = {{1.1, 1.1, 1.1}};
  r.points[4].error.radiance.rms = 5e-4;
  EXPECT_EQ(conclusion_of(r).eight_bits, &r.points[1]);
  r.points[1].times = {{2, 2, 2}};
  r.points[4].samples_per_ray = 60;
  EXPECT_EQ(conclusion_of(r).eight_bits, &r.points[1]);

  // The exact method at fewer look-ups than all others is the only answer.
  r.points[3].samples_per_ray = 30;
  EXPECT_EQ(
      conclusion_text(r),
      "For 8 bits use `--integrator cell-exact`: RMS 5.0e-6, 30 look-ups a ray; no setting is "
      "cheaper.");
}

TEST(Conclusion, SaysWhereASmallerStepHasTheGreaterError) {
  const auto by_step = [](Integrator rule, double step) {
    return Variant{{rule, Sampling::uniform, 0, step}};
  };
  StudyResults r;
  r.scene = to_json(Scene{});
  r.points = {point_of(by_step(Integrator::midpoint, 2), 2.2e-4, 30, 1),
              point_of(by_step(Integrator::midpoint, 1), 2.5e-4, 60, 1),
              point_of(by_step(Integrator::psi_balanced, 2), 1e-4, 30, 1),
              point_of(by_step(Integrator::psi_balanced, 1), 1e-5, 60, 1),
              point_of(by_step(Integrator::psi_balanced, 0.5), 1.04e-5, 120, 1)};
  EXPECT_TRUE(has(conclusion_text(r),
                  " The error rises with a smaller step: midpoint 2.5e-4 at step 1, 2.2e-4 at step "
                  "2."));
  EXPECT_FALSE(has(conclusion_text(r), "1.0e-5 at"));
  r.points[1].arithmetic = r.points[1].error;  // it is float32's
  EXPECT_FALSE(has(conclusion_text(r), "rises"));
}

TEST(Conclusion, NamesNoWinnerWhereRulesCannotDiffer) {
  const auto uniform = [](Integrator rule) { return Variant{{rule, Sampling::uniform, 0, 2}}; };
  StudyResults r;
  r.scene = to_json(Scene{});
  r.points = {point_of(uniform(Integrator::porter_duff), 1e-3, 30, 1),
              point_of(uniform(Integrator::average), 4e-4, 30, 1),
              point_of(uniform(Integrator::psi_balanced), 4e-4, 30, 5),
              point_of(uniform(Integrator::psi_exact), 4e-4, 30, 9)};
  for (std::size_t i : {2u, 3u}) r.points[i].same_as = variant_name(r.points[1].variant);
  EXPECT_EQ(conclusion_text(r),
            "For 8 bits use `--step 2` with average, psi-balanced or psi-exact: RMS 4.0e-4, 30 "
            "look-ups a ray; no setting is cheaper. Pictures by the rules of one list are the same "
            "but for rounding.");
  // the default rule stands for all, whatever their times
  EXPECT_EQ(conclusion_of(r).eight_bits, &r.points[2]);
  EXPECT_TRUE(has(results_json(r), R"("--step 2 --integrator psi-balanced")"));

  Scene surface;
  surface.mode = Mode::isosurface;
  r.scene = to_json(surface);
  r.points = {point_of({{Integrator::porter_duff, Sampling::cells, 1, 0}}, 1e-7, 5, 1)};
  EXPECT_EQ(conclusion_text(r),
            "For 8 bits use `--sampling cells`: RMS 1.0e-7, 5 look-ups a ray; no setting is "
            "cheaper. --mode isosurface integrates nothing, so that the rule and the segments "
            "change no picture.");
}

TEST(Conclusion, RoundingIsSmallBesideThePicture) {
  Image image{2, 1, {{"", {"R", "G", "B", "A"}, {3, 3, 3, 3, 0, 0, 0, NAN}}}, {}};
  EXPECT_NEAR(rounding_rms(image), 8 * 0x1p-23 * std::sqrt(36 / 7.0), 1e-12);
}

TEST(Conclusion, SaysWhatIsOutOfReach) {
  StudyResults r;
  EXPECT_EQ(conclusion_text(r), "");
  r.scene = to_json(Scene{});
  const Variant coarse{{Integrator::porter_duff, Sampling::cells, 4, 0}};
  r.points = {point_of(coarse, 2e-3, 12, 1)};
  EXPECT_EQ(
      conclusion_text(r),
      "No setting of this study is within 8 bits; for an RMS of 1e-2 or less use `--segments 4 "
      "--integrator porter-duff`: RMS 2.0e-3, 12 look-ups a ray.");
  r.points = {point_of(coarse, 0.1, 12, 1)};
  EXPECT_EQ(
      conclusion_text(r),
      "No setting of this study is within 8 bits or an RMS of 1e-2; the least RMS is 1.0e-1, by "
      "`--segments 4 --integrator porter-duff`.");
}

}  // namespace
}  // namespace psivox
