// The parts of a study that need no GPU: plan, files, page. tests/study_cli_test.sh runs
// a study.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/atlas_plan.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/study.h"
#include "study/conclusion.h"
#include "study/page.h"
#include "study/results.h"
#include "thrown.h"

namespace psivox {
namespace {

Sweep small_sweep() {
  Sweep sweep;
  set_sweep(sweep, "integrators", "porter-duff,psi-exact,cell-exact,preintegrated");
  set_sweep(sweep, "segments", "1,2");
  set_sweep(sweep, "steps", "1,0.5");
  return sweep;
}

TEST(Sweep, ListsAreReadAsParametersAre) {
  Sweep sweep = small_sweep();
  EXPECT_EQ(sweep.steps, (std::vector<double>{1, 0.5}));
  set_sweep(sweep, "steps", "2,2,2");
  EXPECT_EQ(sweep.steps, std::vector<double>{2});
  set_sweep(sweep, "integrators", "all");
  EXPECT_EQ(sweep.integrators.size(), std::size(integrators));
  EXPECT_EQ(Sweep().integrators, sweep.integrators);
  for (const auto& [list, text] : {std::pair{"steps", "1,x"},
                                   {"steps", "0"},
                                   {"steps", "all"},
                                   {"steps", ""},
                                   {"segments", "65"},
                                   {"integrators", "psi"},
                                   {"step", "1"},
                                   {"filters", "exact,soft"}})
    EXPECT_THROW(set_sweep(sweep, list, text), Error) << list << ' ' << text;
}

TEST(Plan, SkipsWhatTheSceneRefusesAndSaysWhy) {
  const StudyPlan plan = plan_study(small_sweep(), Scene{});
  std::vector<std::string> names;
  for (const Variant& v : plan.variants) names.push_back(variant_name(v));
  EXPECT_EQ(names, (std::vector<std::string>{
                       "porter-duff cells 1", "porter-duff cells 2", "psi-exact cells 1",
                       "psi-exact cells 2", "cell-exact cells", "porter-duff step 1",
                       "porter-duff step 0.5", "psi-exact step 1", "psi-exact step 0.5"}));
  ASSERT_EQ(plan.skipped.size(), 6u);
  for (const auto& [variant, reason] : plan.skipped) {
    const bool exact = rule_name(variant) == "cell-exact";
    EXPECT_TRUE(has(reason, exact ? "integrates cells" : "--transfer-function")) << reason;
  }
}

TEST(Plan, MaximaAndSurfacesHaveNoRules) {
  Sweep sweep = small_sweep();
  Scene base;
  base.mode = Mode::isosurface;  // found in cells alone
  const StudyPlan surface = plan_study(sweep, base);
  ASSERT_EQ(surface.variants.size(), 1u);
  EXPECT_EQ(variant_name(surface.variants[0]), "porter-duff cells 1");
  EXPECT_EQ(variant_name(surface.skipped.front().variant), "porter-duff cells 2");
  EXPECT_TRUE(has(surface.skipped.front().reason, "isosurface integrates nothing"));
  base.mode = Mode::mip;
  EXPECT_EQ(plan_study(sweep, base).variants.size(), 3u);  // cells, and two steps
  base.mode = Mode::xray;                                  // its optical depths are the rules'
  EXPECT_EQ(plan_study(sweep, base).variants.size(), plan_study(sweep, Scene{}).variants.size());
}

TEST(Plan, TolerancesLeaveTheWayOpen) {
  Sweep sweep = small_sweep();
  set_sweep(sweep, "integrators", "psi-exact");
  set_sweep(sweep, "samplings", "uniform");
  set_sweep(sweep, "steps", "1");
  set_sweep(sweep, "tolerances", "1e-2,1e-3");
  Scene base;
  base.early_termination = 1.0 / 16384;
  const StudyPlan plan = plan_study(sweep, base);
  ASSERT_EQ(plan.variants.size(), 3u);
  EXPECT_EQ(variant_name(plan.variants[1]), "chosen for 0.01");
  EXPECT_EQ(variant_name(refinement(plan.variants[1])), "chosen by tolerance");
  EXPECT_EQ(refinement(plan.variants[1]), refinement(plan.variants[2]));
  EXPECT_FALSE(refinement(plan.variants[0]) == refinement(plan.variants[1]));
  EXPECT_TRUE(is_coarser(plan.variants[1], plan.variants[2]));
  const Scene scene = scene_of(plan.variants[1], base);
  EXPECT_EQ(scene.tolerance, 1e-2);
  EXPECT_EQ(scene.resolved_early_termination(), 1e-2 / 4);
  base.split_knots = true;  // sets the method, so that no variant is left
  EXPECT_TRUE(plan_study(sweep, base).variants.empty());
}

TEST(Plan, OptionsOfAVariantRenderIt) {
  Sweep sweep = small_sweep();
  sweep.samplings.push_back(Sampling::template_);
  sweep.texels.push_back(TexelType::code16);
  sweep.tolerances = {1e-3};
  Scene base;
  base.projection = Projection::orthographic;
  const StudyPlan plan = plan_study(sweep, base);
  ASSERT_GT(plan.variants.size(), 8u);
  for (const Variant& variant : plan.variants) {
    Scene scene = base;
    std::istringstream words(options_of(variant));
    for (std::string name, value; words >> name >> value;)
      set_parameter(scene, name.substr(2), value);
    const Scene wanted = scene_of(variant, base);
    EXPECT_EQ(scene.resolved_sampling(), wanted.resolved_sampling()) << words.str();
    EXPECT_EQ(scene.step, wanted.step) << words.str();
    // auto, the default, is float32 where there is no tolerance
    EXPECT_EQ(has_codes(scene.texel), has_codes(wanted.texel)) << words.str();
    EXPECT_EQ(scene.tolerance, wanted.tolerance) << words.str();
    if (variant.tolerance) continue;
    EXPECT_EQ(scene.resolved_integrator(), wanted.resolved_integrator()) << words.str();
    EXPECT_EQ(scene.segments, wanted.segments) << words.str();
  }
}

StudyResults some_results() {
  StudyResults r;
  r.version = "1";
  r.git = "abc";
  r.processor = "a processor, \"quoted\"";
  r.system = "system";
  r.threads = 2;
  r.renderer = "GL";
  r.input = "a.vdb";
  r.input_hash = "0123";
  Scene scene;
  scene.input = r.input;
  r.scene = to_json(scene);
  r.reference_bound = 1e-13;
  r.repeats = 2;
  StudyPlan plan = plan_study(small_sweep(), Scene{});
  plan.variants.push_back({Integrator::psi_exact, Sampling::uniform, 0, 1});
  plan.variants.back().resolution = {32, 24};
  plan.variants.emplace_back();
  plan.variants.back().tolerance = 1e-3;
  r.skipped = plan.skipped;
  double x = 0.1;
  for (const Variant& variant : plan.variants) {
    StudyPoint p;
    p.variant = variant;
    p.error.radiance = {x, 2 * x, 3, 4, x / 3, -x / 7, 0};
    p.error.alpha = {x / 9, x, 5, 6, x / 2, x / 11, 1};
    if (variant.method.sampling == Sampling::cells) p.step_error = p.arithmetic = p.error;
    if (variant.method.step == 1) p.same_as = "porter-duff step 1";
    if (variant.tolerance) {
      p.chosen = {Integrator::midpoint, Sampling::uniform, 0, 9.5};
      p.estimate = x / 2;
    }
    p.samples_per_ray = 10 / x;
    p.steps_per_ray = 7 / x;
    p.atlas_bytes = 12345678901;
    p.difference_scale = x;
    p.times = {{x, 2 * x, 3 * x}, {1.1 * x, 2.2 * x, 3.3 * x}};
    r.points.push_back(p);
    x *= 0.7;
  }
  return r;
}

TEST(Results, JsonRoundTrip) {
  const StudyResults r = some_results();
  const StudyResults back = results_from_json(results_json(r), "test");
  EXPECT_EQ(back.points, r.points);
  EXPECT_EQ(results_json(back), results_json(r));
  EXPECT_EQ(results_csv(back), results_csv(r));
  EXPECT_TRUE(has(results_json(r), "\"command\": \"psivox render a.vdb --output=picture.png"));
  for (const char* text : {"", "{}", "[]", R"({"psivox_study": 2})"})
    EXPECT_THROW(results_from_json(text, "test"), Error) << text;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

TEST(Results, CsvHasEveryNumberWithAllItsDigits) {
  const StudyResults r = some_results();
  std::istringstream lines(results_csv(r));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> header = split(line);
  const auto column = [&](const std::string& name) {
    const auto at = std::find(header.begin(), header.end(), name);
    EXPECT_NE(at, header.end()) << name;
    return std::size_t(at - header.begin());
  };
  for (const StudyPoint& point : r.points) {
    ASSERT_TRUE(std::getline(lines, line));
    const std::vector<std::string> cells = split(line);
    ASSERT_EQ(cells.size(), header.size());
    const auto number = [&](const char* name) { return std::stod(cells[column(name)]); };
    const Variant marched = point.chosen.value_or(point.variant);
    EXPECT_EQ(cells[column("integrator")], rule_name(marched));
    EXPECT_EQ(number("step"), marched.method.step);
    EXPECT_EQ(number("tolerance"), point.variant.tolerance.value_or(0));
    EXPECT_EQ(number("estimate"), point.estimate);
    EXPECT_EQ(cells[column("resolution")], point.variant.resolution.x ? "32x24" : "1280x720");
    EXPECT_EQ(number("rms"), point.error.rms());
    EXPECT_EQ(number("radiance_p99"), point.error.radiance.p99);
    EXPECT_EQ(number("alpha_mean"), point.error.alpha.mean);
    EXPECT_EQ(number("alpha_max_y"), 6);
    EXPECT_EQ(number("samples_per_ray"), point.samples_per_ray);
    EXPECT_EQ(number("cpu_ms_median"), median_cpu_ms(point));
    EXPECT_EQ(number("gpu_ms_max"), spread(point, &TimeSample::gpu_ms).max);
    EXPECT_EQ(cells[column("step_error_radiance_rms")].empty(), !point.step_error);
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(Resume, OnlyTheSameStudyGoesOn) {
  const StudyResults begun = some_results();
  Sweep sweep = small_sweep();
  StudyPlan plan = plan_study(sweep, Scene{});
  set_sweep(sweep, "resolutions", "32x24");
  for (const Variant& variant : plan_study(sweep, Scene{}).variants)
    plan.variants.push_back(variant);
  plan.variants.emplace_back();
  plan.variants.back().tolerance = 1e-3;
  StudyResults next = begun;
  next.points.clear();
  next.input = "elsewhere/a.vdb";  // the same bytes under another name
  EXPECT_EQ(resume_obstacle(begun, next, plan), "");

  StudyPlan more = plan;
  more.variants.push_back({Integrator::average, Sampling::uniform, 0, 0.125});
  EXPECT_EQ(resume_obstacle(begun, next, more), "");
  StudyPlan less = plan;
  less.variants.erase(less.variants.begin());
  EXPECT_TRUE(has(resume_obstacle(begun, next, less), "porter-duff cells 1"));

  const auto obstacle = [&](auto change) {
    StudyResults other = next;
    change(other);
    return resume_obstacle(begun, other, plan);
  };
  EXPECT_NE(obstacle([](StudyResults& s) { s.input_hash = "4567"; }), "");
  EXPECT_NE(obstacle([](StudyResults& s) { s.renderer = "another GL"; }), "");
  EXPECT_NE(obstacle([](StudyResults& s) { s.git = "def"; }), "");
  const std::string scene = obstacle([](StudyResults& s) {
    Scene changed;
    changed.resolution = {64, 64};
    s.scene = to_json(changed);
  });
  EXPECT_TRUE(has(scene, "--resolution"));
}

TEST(Page, HoldsItsDataAsNoMarkup) {
  const std::filesystem::path folder = testing::TempDir();
  write_page(folder, "a < b", R"({"name": "</script><img src=x>"})", {{"none.png"}}, {"none.html"});
  const std::string page = read_text((folder / page_name).string(), "page");
  EXPECT_TRUE(has(page, "<title>a &lt; b</title>"));
  EXPECT_FALSE(has(page, "<img src=x"));
  EXPECT_TRUE(has(page, R"({"name": "\u003c/script>\u003cimg src=x>"})"));
  EXPECT_TRUE(has(page, R"({"pictures":{},"links":[]})"));
  for (const char* mark : {"@DATA@", "@FILES@", "@STYLE@", "@SCRIPTS@", "@POLICY@"})
    EXPECT_FALSE(has(page, mark)) << mark;
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
