// The requirements between parameters, and the values of a file's scene that the command line
// clears.

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/text_file.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "thrown.h"

namespace psivox {
namespace {

Scene with(const char* name, const char* text) {
  Scene scene;
  set_parameter(scene, name, text);
  return scene;
}

Scene over(Scene scene, const std::vector<Setting>& settings) {
  apply_over(scene, settings);
  return scene;
}

TEST(Validate, RefusesContradictions) {
  Scene scene = with("step", "2");
  EXPECT_NO_THROW(validate(scene));
  scene.sampling = Sampling::cells;
  EXPECT_EQ(usage_error([&] { validate(scene); }),
            "--step is for --sampling uniform, not cells; leave one of them out");
  scene = with("ortho-width", "2");
  EXPECT_NE(usage_error([&] { validate(scene); }), "no error");
  scene.projection = Projection::orthographic;
  EXPECT_NO_THROW(validate(scene));
  scene = with("camera-up", "0,0,0");
  EXPECT_NE(usage_error([&] { validate(scene); }), "no error");
  scene = with("camera-position", "1,2,3");
  scene.camera_target = glm::dvec3(1, 2, 3);
  EXPECT_NE(usage_error([&] { validate(scene); }), "no error");
}

TEST(Validate, RefusesOptionsWithoutTheirCounterpart) {
  const auto error = [](std::vector<Setting> settings) {
    Scene scene;
    for (const Setting& setting : settings) set_parameter(scene, setting.name, setting.text);
    return usage_error([&] { validate(scene); });
  };
  const Setting map{"colormap", "hot"}, function{"transfer-function", "a.json"},
      flat{"projection", "orthographic"}, ray_template{"sampling", "template"};
  EXPECT_EQ(error({map, function}),
            "--transfer-function and --colormap exclude each other; leave one of them out");
  EXPECT_EQ(error({{"range", "0,1"}}), "no error");
  EXPECT_EQ(error({{"opacity", "0:0,1:1"}}), "no error");
  EXPECT_EQ(error({{"range", "99%,1%"}}), "--range MIN,MAX: MIN must be below MAX");
  EXPECT_EQ(error({{"range", "1,99%"}}), "no error");  // known only with the grid
  for (const Setting& window : {Setting{"range", "0,1"}, Setting{"opacity", "0:0,1:1"}})
    EXPECT_EQ(error({{"transfer-function", "f.json"}, window}),
              "--transfer-function has values of its own; leave out --range and --opacity");
  EXPECT_EQ(error({map, {"range", "1,1"}}), "--range MIN,MAX: MIN must be below MAX");
  EXPECT_EQ(error({map, {"range", "0,1"}}), "no error");
  EXPECT_EQ(
      error({{"classification", "pre"}}),
      "--classification pre needs a function; give --transfer-function, --colormap or --opacity");
  EXPECT_EQ(error({{"classification", "pre"}, function}), "no error");
  EXPECT_EQ(error({{"split-knots", "true"}}),
            "--split-knots needs a function; give --transfer-function or --colormap");
  EXPECT_EQ(error({{"split-knots", "true"}, map}), "no error");
  EXPECT_EQ(error({{"luminance-grid", "a"}, {"temperature-grid", "b"}}),
            "--luminance-grid and --temperature-grid exclude each other; leave one of them out");
  EXPECT_EQ(error({{"luminance-grid", "a"}, map}),
            "--colormap and --luminance-grid exclude each other; leave one of them out");
  EXPECT_EQ(error({{"temperature-grid", "a"}, map}),
            "--colormap and --temperature-grid exclude each other; leave one of them out");
  EXPECT_EQ(error({{"temperature-grid", "a"}, function}), "no error");  // it may lack colours
  EXPECT_EQ(error({{"light", "0,0,0"}}), "--light has no direction: it is 0");
  // too short to be normalised
  EXPECT_EQ(error({{"light", "1e-200,0,0"}}), "--light has no direction: it is 0");
  EXPECT_EQ(error({{"albedo", "0.5"}, {"phase-g", "0.5"}}), "no error");
  EXPECT_EQ(error({{"isovalue", "1"}}),
            "--isovalue is for --mode isosurface; give both or neither");
  EXPECT_EQ(error({{"isovalue", "1"}, {"mode", "isosurface"}}), "no error");
  EXPECT_EQ(error({{"mode", "isosurface"}, {"step", "1"}}),
            "--mode isosurface finds its surface in cells; it goes with --sampling cells, without "
            "--step");
  EXPECT_EQ(error({{"mode", "isosurface"}, {"sampling", "cells"}}), "no error");
  EXPECT_EQ(error({{"lmip-threshold", "1"}, {"mode", "mip"}}),
            "--lmip-threshold is for --mode lmip; give both or neither");
  EXPECT_EQ(error({{"lmip-threshold", "1"}, {"mode", "lmip"}}), "no error");
  EXPECT_EQ(error({ray_template}),
            "--sampling template needs parallel rays; give --projection orthographic with it");
  EXPECT_EQ(error({ray_template, flat, {"step", "1"}}),
            "--step is for --sampling uniform, not template; leave one of them out");
  EXPECT_EQ(error({ray_template, flat, {"connectivity", "18"}}), "no error");
  EXPECT_EQ(error({ray_template, flat, {"connectivity", "7"}}), "--connectivity is 6, 18 or 26");
  EXPECT_EQ(error({{"connectivity", "6"}}),
            "--connectivity is for --sampling template; give both or neither");
  EXPECT_NE(error({ray_template, flat, {"integrator", "cell-exact"}}), "no error");
}

TEST(Tolerance, ExcludesEveryParameterOfTheMethod) {
  const std::vector<Setting> method = {
      {"sampling", "uniform"}, {"integrator", "average"}, {"step", "2"},       {"segments", "3"},
      {"split-knots", "true"}, {"filter", "hardware"},    {"texel", "code16"},
  };
  std::size_t excluded = 0;
  for (const Parameter& p : parameters()) excluded += p.under_tolerance != UnderTolerance::free;
  EXPECT_EQ(excluded, method.size());
  for (const Setting& setting : method) {
    Scene scene = with("colormap", "hot");  // required by --split-knots
    EXPECT_TRUE(leaves_method_open(scene));
    EXPECT_EQ(with_default_tolerance(scene).tolerance, default_tolerance);
    set_parameter(scene, setting.name, setting.text);
    EXPECT_FALSE(leaves_method_open(scene)) << setting.name;
    EXPECT_EQ(with_default_tolerance(scene).tolerance, std::nullopt);
    EXPECT_NO_THROW(validate(scene)) << setting.name;
    const Scene method_alone = scene;
    scene.tolerance = 0.1;
    EXPECT_TRUE(has(usage_error([&] { validate(scene); }), "--" + setting.name));
    // The command line's value replaces the file's.
    scene = method_alone;
    apply_over(scene, std::vector<Setting>{{"tolerance", "0.1"}});
    EXPECT_TRUE(has_default(scene, *find_parameter(setting.name))) << setting.name;
    EXPECT_NO_THROW(validate(scene)) << setting.name;
    apply_over(scene, std::vector<Setting>{setting});
    EXPECT_EQ(scene.tolerance, std::nullopt) << setting.name;
    EXPECT_NO_THROW(validate(scene)) << setting.name;
  }
  Scene scene = with("tolerance", "0.1");
  EXPECT_FALSE(leaves_method_open(scene));
  EXPECT_EQ(with_default_tolerance(scene).tolerance, 0.1);
  scene.filter = Filter::hardware;
  EXPECT_EQ(usage_error([&] { check_method_unset(scene, "--aov deep"); }),
            "--aov deep needs --filter exact: it does not estimate the error of --filter "
            "hardware");
  EXPECT_FALSE(leaves_method_open(with("renderer", "reference")));
  EXPECT_TRUE(leaves_method_open(with("renderer", "march-double")));
  // Spelling out a default is not a choice.
  scene = with("tolerance", "0.1");
  apply_over(scene, std::vector<Setting>{{"sampling", "auto"}, {"filter", "exact"}});
  EXPECT_EQ(scene.tolerance, 0.1);
}

TEST(Tolerance, ExcludesWhatTheUserGuideSays) {
  const std::string guide = read_text(PSIVOX_ASSETS "/../docs/user-guide.md", "guide");
  std::istringstream section(guide.substr(guide.find("\n### Method\n")));
  std::set<std::string> listed, excluded;
  for (std::string line; std::getline(section, line);) {
    if (line.starts_with("| `--")) listed.insert(line.substr(5, line.find_first_of(" `", 5) - 5));
    if (!listed.empty() && line.empty()) break;  // the end of the table
  }
  for (const Parameter& p : parameters())
    if (p.under_tolerance != UnderTolerance::free) excluded.insert(p.name);
  EXPECT_EQ(listed, excluded);
}

TEST(ApplyOver, ReplacesTheSourceOfLuminanceAndTheMode) {
  Scene map = with("colormap", "hot");
  map.range = glm::dvec2(0, 1);
  map.classification = Classification::pre;
  const Setting function{"transfer-function", "a.json"}, grid{"luminance-grid", "color"};
  Scene s = over(map, {function});
  EXPECT_EQ(s.colormap, std::nullopt);
  EXPECT_EQ(s.range, std::nullopt);
  EXPECT_EQ(s.classification, Classification::pre);
  s = over(map, {grid});
  EXPECT_EQ(s.colormap, std::nullopt);
  EXPECT_EQ(s.classification, Classification::post);
  EXPECT_NO_THROW(validate(s));
  EXPECT_NO_THROW(validate(over(map, {{"colormap", "none"}})));
  EXPECT_EQ(over(map, {{"colormap", "gray"}}).range, glm::dvec2(0, 1));
  EXPECT_THROW(validate(over(map, {function, {"range", "2,3"}})), Error);
  EXPECT_THROW(validate(over(map, {function, {"colormap", "gray"}})), Error);
  EXPECT_EQ(over(with("transfer-function", "a.json"), {{"colormap", "gray"}}).transfer_function,
            "");
  s = over(with("temperature-grid", "heat"), {grid});
  EXPECT_EQ(s.temperature_grid, "");
  EXPECT_EQ(s.luminance_grid, "color");
  s = over(with("luminance-grid", "color"), {{"temperature-grid", "heat"}});
  EXPECT_EQ(s.luminance_grid, "");

  Scene surface = with("mode", "isosurface");
  surface.isovalue = {{0.5}};
  EXPECT_TRUE(over(surface, {{"mode", "mip"}}).isovalue.empty());
  EXPECT_EQ(over(surface, {}).isovalue, surface.isovalue);
  EXPECT_NO_THROW(validate(over(with("step", "0.5"), {{"mode", "isosurface"}})));
  EXPECT_THROW(validate(over(surface, {{"step", "0.5"}})), Error);
  Scene lmip = with("mode", "lmip");
  lmip.lmip_threshold = 0.5;
  EXPECT_EQ(over(lmip, {{"mode", "mip"}}).lmip_threshold, 0);
  EXPECT_EQ(over(lmip, {}).lmip_threshold, 0.5);
}

TEST(ApplyOver, ARaysIntegralIsExposedAutomaticallyUnlessItsExposureIsGiven) {
  const auto exposure = [](const Scene& scene, const std::vector<Setting>& settings) {
    return over(scene, settings).exposure;
  };
  const Setting xray{"mode", "xray"}, alpha{"mode", "alpha"};
  EXPECT_EQ(exposure({}, {xray}), std::nullopt);
  EXPECT_EQ(exposure({}, {xray, {"exposure", "0"}}), 0);
  EXPECT_EQ(exposure({}, {{"mode", "mip"}}), 0);
  Scene integral;  // as a picture's metadata have it
  integral.mode = Mode::xray;
  integral.exposure = -3;
  EXPECT_EQ(exposure(integral, {{"step", "2"}}), -3);
  EXPECT_EQ(exposure(integral, {xray}), -3);
  EXPECT_EQ(exposure(integral, {alpha}), 0);
  EXPECT_EQ(exposure(integral, {alpha, {"exposure", "-1"}}), -1);
  EXPECT_EQ(scene_from_json(R"({"mode": "xray"})").exposure, std::nullopt);
  EXPECT_EQ(scene_from_json(R"({"mode": "xray", "exposure": 0})").exposure, 0);
  EXPECT_EQ(scene_from_json(to_json(integral)).exposure, -3);
}

TEST(ApplyOver, LeavesTheRayTemplate) {
  Scene scene = with("sampling", "template");
  scene.projection = Projection::orthographic;
  scene.connectivity = 6;
  EXPECT_EQ(over(scene, {}).connectivity, 6);
  for (const Setting& setting :
       std::vector<Setting>{{"step", "2"}, {"sampling", "cells"}, {"projection", "perspective"}}) {
    const Scene s = over(scene, {setting});
    EXPECT_NE(s.sampling, Sampling::template_) << setting.name;
    EXPECT_EQ(s.connectivity, 26) << setting.name;
    EXPECT_NO_THROW(validate(s)) << setting.name;
  }
  Scene uniform = with("step", "2");
  uniform.projection = Projection::orthographic;
  EXPECT_EQ(over(uniform, {{"sampling", "template"}}).step, std::nullopt);
  EXPECT_THROW(validate(over(with("step", "2"), {{"sampling", "template"}})), Error);
}

TEST(ApplyOver, ClearsWhatTheCommandLineContradicts) {
  Scene uniform = with("step", "2");
  uniform.sampling = Sampling::uniform;
  EXPECT_EQ(over(uniform, {{"sampling", "cells"}}).step, std::nullopt);
  EXPECT_EQ(over(uniform, {{"sampling", "uniform"}}).step, 2.0);
  Scene cells = with("sampling", "cells");
  EXPECT_EQ(over(cells, {{"step", "3"}}).resolved_sampling(), Sampling::uniform);
  EXPECT_THROW(validate(over(cells, {{"step", "3"}, {"sampling", "cells"}})), Error);
  Scene flat = with("ortho-width", "3");
  flat.projection = Projection::orthographic;
  EXPECT_EQ(over(flat, {{"projection", "perspective"}}).ortho_width, std::nullopt);
  EXPECT_EQ(over(with("fov", "30"), {{"focal-length", "35"}}).fov, std::nullopt);
  EXPECT_EQ(over(with("fov", "30"), {{"focal-length", "35"}, {"fov", "40"}}).fov, 40.0);
  EXPECT_EQ(over(with("fov", "30"), {{"fov", "auto"}}).fov, std::nullopt);
}

}  // namespace
}  // namespace psivox
