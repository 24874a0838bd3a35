// The table of parameters: the values that the command line and JSON read, print and refuse.

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "colour/colour.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "thrown.h"

namespace psivox {
namespace {

std::string refusal(const char* name, const char* text) {
  Scene scene;
  return usage_error([&] { set_parameter(scene, name, text); });
}

Scene with(const char* name, const char* text) {
  Scene scene;
  set_parameter(scene, name, text);
  return scene;
}

TEST(Parameters, EveryRowHasAUniqueNameADefaultAndHelp) {
  for (const Parameter& p : parameters()) {
    EXPECT_EQ(find_parameter(p.name), &p);
    EXPECT_FALSE(p.help.empty()) << p.name;
    EXPECT_TRUE(p.positional || !p.default_text.empty()) << p.name;
    EXPECT_FALSE(has(p.name, "_"));
  }
  EXPECT_EQ(find_parameter("setp"), nullptr);
}

TEST(Parameters, TextOfEveryDefaultReadsBack) {
  const Scene defaults;
  for (const Parameter& p : parameters()) {
    Scene scene;
    set_parameter(scene, p.name, parameter_text(defaults, p));
    EXPECT_EQ(to_json(scene), to_json(defaults)) << p.name;
  }
}

TEST(Parameters, ReadsEveryKind) {
  EXPECT_EQ(with("grid", "density[1]").grid, "density[1]");
  EXPECT_EQ(with("strict", "true").strict, true);
  EXPECT_EQ(with("segments", "7").segments, 7);
  EXPECT_EQ(with("device", "-1").device, -1);
  EXPECT_EQ(with("luminance-scale", "1e-3").luminance_scale, 1e-3);
  EXPECT_EQ(with("extinction", ".5").extinction, 0.5);
  EXPECT_EQ(with("extinction", "auto").extinction, std::nullopt);
  EXPECT_EQ(with("camera-up", "0,0,1").camera_up, glm::dvec3(0, 0, 1));
  EXPECT_EQ(with("camera-position", "-1,-.5,2e3").camera_position, glm::dvec3(-1, -.5, 2000));
  EXPECT_EQ(with("background", "none").background, std::nullopt);
  EXPECT_EQ(with("resolution", "640x480").resolution, glm::ivec2(640, 480));
  EXPECT_EQ(with("integrator", "psi-weighted").integrator, Integrator::psi_weighted);
  EXPECT_EQ(with("renderer", "march-double").renderer, RendererKind::march_double);
  EXPECT_EQ(with("sampling", "template").sampling, Sampling::template_);
  EXPECT_EQ(with("transfer-function", "a b.json").transfer_function, "a b.json");
  EXPECT_EQ(with("colormap", "hot").colormap, Colormap::hot);
  EXPECT_EQ(with("colormap", "none").colormap, std::nullopt);
  EXPECT_EQ(with("range", "-1,.5").range, glm::dvec2(-1, 0.5));
  EXPECT_EQ(with("range", "auto").range, std::nullopt);
  EXPECT_EQ(with("range", "1%,P99.5%").range, MapRange({1, 99.5}, {true, true}));
  EXPECT_EQ(with("range", "-3,99%").range, MapRange({-3, 99}, {false, true}));
  EXPECT_EQ(with("opacity", "0:0,0.3:0.1,1:20").opacity,
            (OpacityCurve{{{0, 0}, {0.3, 0.1}, {1, 20}}}));
  EXPECT_EQ(with("opacity", "none").opacity, std::nullopt);
  EXPECT_EQ(with("mode", "back-to-front").mode, Mode::back_to_front);
  EXPECT_EQ(with("isovalue", "-2").isovalue, (std::vector<ShownSurface>{{-2}}));
  EXPECT_EQ(with("isovalue", "0.2,0.5:#f80:0.3,1:red,2::0.5,3:0.5").isovalue,
            (std::vector<ShownSurface>{{0.2},
                                       {0.5, named_color("#f80"), 0.3},
                                       {1, glm::dvec3(1, 0, 0)},
                                       {2, {}, 0.5},
                                       {3, {}, 0.5}}));
  EXPECT_EQ(with("value-scale", "log").value_scale, ValueScale{ValueScale::Kind::log});
  EXPECT_EQ(with("value-scale", "symlog:0.5").value_scale,
            (ValueScale{ValueScale::Kind::symlog, 0.5}));
  EXPECT_EQ(with("color-bar", "true").color_bar, "");
  EXPECT_EQ(with("color-bar", "false").color_bar, std::nullopt);
  EXPECT_EQ(with("color-bar", "heat [K]").color_bar, "heat [K]");
  EXPECT_EQ(with("end-corrections", "false").end_corrections, false);
  EXPECT_EQ(with("phase-g", "-.5").phase_g, -0.5);
  EXPECT_TRUE(with("light", "none").lights.empty());
  using Lights = std::vector<DirectionalLight>;
  EXPECT_EQ(with("light", "0,-1,.5").lights, (Lights{{{0, -1, 0.5}, glm::dvec3(1)}}));
  EXPECT_EQ(with("light", "0,-1,-2,3,2,0").lights, (Lights{{{0, -1, -2}, {3, 2, 0}}}));
  EXPECT_EQ(with("light", "camera:1,-1,-2,3,2,0;0,0,1").lights,
            (Lights{{{1, -1, -2}, {3, 2, 0}, true}, {{0, 0, 1}, glm::dvec3(1)}}));
  const std::vector<std::string> volumes{"a b.vdb scale=2", "c.vdb"};
  EXPECT_EQ(with("volumes", "a b.vdb scale=2;c.vdb").volumes, volumes);
  EXPECT_EQ(scene_from_json(to_json(with("volumes", "a b.vdb scale=2;c.vdb"))).volumes, volumes);
  EXPECT_TRUE(with("volumes", "none").volumes.empty());
}

TEST(Parameters, NoToleranceEndsARayWhereItBegins) {
  EXPECT_EQ(with("tolerance", "0.01").resolved_early_termination(), 0.0025);
  EXPECT_LT(with("tolerance", "100").resolved_early_termination(), 1);
}

TEST(Parameters, OfAFurtherVolumeAreItsOwnOrTheScenes) {
  Scene scene = with("luminance", "0.5,1,2");
  scene.grid = "heat";
  const Scene own = scene_of_volume(scene, "a =b.vdb scale=2 extinction=3");
  EXPECT_EQ(own.input, "a =b.vdb");
  EXPECT_EQ(own.grid, "");
  EXPECT_EQ(own.scale, 2);
  EXPECT_EQ(own.extinction, 3.0);
  EXPECT_EQ(own.luminance, scene.luminance);
}

TEST(Parameters, OfAFurtherVolumeAreNamedByTheTable) {
  std::string own, side;
  Scene scene;
  for (const Parameter& p : parameters()) {
    if (may_be_of_volume(p)) own += p.name + ", ";
    if (!names_side_grid(p)) continue;
    side += p.name + " ";
    set_parameter(scene, p.name, "a");
    EXPECT_TRUE(has_default(scene_of_volume(scene, "b.vdb"), p)) << p.name;
  }
  EXPECT_EQ(side, "luminance-grid temperature-grid emission-grid albedo-grid ");
  own.resize(own.size() - 2);
  EXPECT_TRUE(find_parameter("volumes")->help.ends_with(": " + own)) << own;
  EXPECT_EQ(own,
            "grid, scale, rotate, translate, extinction, luminance, temperature-scale, "
            "temperature-offset, emission-grid, emission-scale, emission-color, albedo, "
            "albedo-grid");
}

TEST(Parameters, ReadsColoursAsLinearNumbersOrCodesOfSrgb) {
  const double half = linear_from_srgb(128 / 255.0);
  EXPECT_EQ(with("luminance", "0.5,1,2").luminance, glm::dvec3(0.5, 1, 2));
  EXPECT_EQ(with("background", "#ff8000").background, glm::dvec3(1, half, 0));
  EXPECT_EQ(with("background", "#F80").background, glm::dvec3(1, linear_from_srgb(136 / 255.0), 0));
  EXPECT_EQ(with("sky", "White").sky, glm::dvec3(1));
  EXPECT_EQ(with("luminance", "aliceblue").luminance->z, 1);
  EXPECT_EQ(with("luminance", "yellowgreen").luminance->x, linear_from_srgb(154 / 255.0));
  EXPECT_EQ(with("light", "0,-1,0,lime").lights.front().color, glm::dvec3(0, 1, 0));
  for (const char* bad :
       {"", "re", "red=ff0000 rosybrown", "#", "#12", "#1234567", "#gggggg", "#+12345"})
    EXPECT_NE(refusal("luminance", bad), "no error") << bad;
}

TEST(Parameters, TakesWholeNumbersUpTo255ForCodesBehindTheMediumAlone) {
  const double half = linear_from_srgb(128 / 255.0);
  EXPECT_EQ(with("background", "255,128,0").background, glm::dvec3(1, half, 0));
  EXPECT_EQ(with("background", "1,1,0").background, glm::dvec3(1, 1, 0));
  EXPECT_EQ(with("background", "256,0,0").background, glm::dvec3(256, 0, 0));
  EXPECT_EQ(with("background", "2.0,2,2").background, glm::dvec3(2));
  EXPECT_EQ(with("luminance", "255,128,0").luminance, glm::dvec3(255, 128, 0));
  const auto notice = [](const char* name, const char* text) {
    return color_notice(*find_parameter(name), text);
  };
  EXPECT_TRUE(has(notice("background", "255,128,0"), "#ff8000"));
  EXPECT_TRUE(has(notice("luminance", "255,128,0"), "#ff8000"));
  EXPECT_TRUE(has(notice("light", "1,0,0;0,-1,0,255,0,9"), "0,-1,0,#ff0009"));
  EXPECT_EQ(notice("luminance", "9,9,9"), "");
  EXPECT_EQ(notice("light", "0,-1,0,3,3,3"), "");
  EXPECT_EQ(notice("light", "0,0,100"), "");
  EXPECT_EQ(notice("camera-position", "0,0,100"), "");
  // what is written reads back as the same number
  const Scene bright = with("background", "2.0,2,2");
  const std::string text = parameter_text(bright, "background");
  EXPECT_EQ(with("background", text.c_str()).background, bright.background);
  EXPECT_EQ(scene_from_json(to_json(bright)).background, bright.background);
  EXPECT_EQ(scene_from_json(R"({"background": [2, 2, 2]})").background, bright.background);
  EXPECT_EQ(scene_from_json(R"({"background": "red"})").background, glm::dvec3(1, 0, 0));
}

TEST(Parameters, ReadsSizesLikeGnuTools) {
  EXPECT_EQ(with("memory-limit", "0").memory_limit, 0u);
  EXPECT_EQ(with("memory-limit", "123456789012345678").memory_limit, 123456789012345678u);
  EXPECT_EQ(with("memory-limit", "512M").memory_limit, 512u << 20);
  EXPECT_EQ(with("memory-limit", "1.5GiB").memory_limit, 3u << 29);
  EXPECT_EQ(with("memory-limit", "2G").memory_limit, 1ull << 31);
  EXPECT_EQ(with("memory-limit", "2GB").memory_limit, 2'000'000'000u);
  EXPECT_EQ(with("memory-limit", "10K").memory_limit, 10240u);
  EXPECT_EQ(with("memory-limit", "7B").memory_limit, 7u);
  for (const char* bad : {"", "-1", "1.5X", "M", "1 M", "1MM", "1e3", "99999999T", "1MiBB", "1Ki"})
    EXPECT_NE(refusal("memory-limit", bad), "no error") << bad;
}

TEST(Parameters, RefusalNamesOptionTextAndWhatIsExpected) {
  EXPECT_EQ(refusal("step", "abc"),
            "--step 'abc': expected auto or a number above 0 [voxels of the finest axis]");
  EXPECT_EQ(refusal("segments", "65"), "--segments '65': expected a whole number from 1 to 64");
  EXPECT_EQ(
      refusal("early-termination", "1"),
      "--early-termination '1': expected auto or a number at least 0 and below 1 [transmittance]");
  EXPECT_EQ(refusal("fov", "180"),
            "--fov '180': expected auto or a number above 0 and below 180 [degrees]");
  EXPECT_EQ(refusal("resolution", "640"),
            "--resolution '640': expected WxH in whole numbers, each from 1 to 65536 [pixels]");
  EXPECT_EQ(
      refusal("luminance", "1,2"),
      "--luminance '1,2': expected auto or #rrggbb, a name of CSS, or three linear numbers R,G,B, "
      "each at least 0");
  EXPECT_EQ(refusal("range", "1"),
            "--range '1': expected auto or two numbers MIN,MAX or percentiles such as 1%,99%");
  EXPECT_EQ(refusal("light", "1,0,0,1"),
            "--light '1,0,0,1': expected none or X,Y,Z[,COLOUR], colours as #rrggbb, names of CSS, "
            "or R,G,B at least 0");
  EXPECT_EQ(refusal("phase-g", "1"), "--phase-g '1': expected a number above -1 and below 1");
  EXPECT_EQ(
      refusal("colormap", "virdis"),
      "--colormap 'virdis': expected none or viridis or inferno or magma or plasma or cividis "
      "or turbo or coolwarm or gray or hot or labels; did you mean viridis?");
  EXPECT_EQ(refusal("integrator", "psi-wieghted"),
            "--integrator 'psi-wieghted': expected auto or porter-duff or midpoint or average or "
            "linear-luminance or opacity-linear or psi-weighted or psi-balanced or psi-exact or "
            "psi-fit or psi-table or linear-source or cell-exact or preintegrated or "
            "preintegrated-fast; did you mean psi-weighted?");
  EXPECT_EQ(refusal("strict", "yes"), "--strict 'yes': expected true or false");
  EXPECT_EQ(refusal("scale", "1e39"),
            "--scale '1e39': expected a number above 0; numbers go up to 3.4e38");
  EXPECT_TRUE(has(refusal("light", "1,0,0,-1e39,1,1"), "; numbers go up to"));
  EXPECT_EQ(refusal("setp", "1"), "unknown parameter 'setp'; did you mean step?");
  EXPECT_EQ(refusal("qqqqqq", "1"), "unknown parameter 'qqqqqq'");
  EXPECT_EQ(refusal("strict", "1\n2"), "--strict '1\\x0a2': expected true or false");
}

TEST(Parameters, RefusesWhatIsNoNumberOrOutOfRange) {
  const std::pair<const char*, std::vector<const char*>> bad[] = {
      {"step", {"", "0", "-1", "1x", " 1", "1 ", "nan", "inf", "1e999", "0x10", "1,5"}},
      {"range", {"1", "1,2,3", "1%,101%", "P1,P2", "", "1x2"}},
      {"opacity", {"", "0.5", "0:0,0:1", "0:0,2:1", "0:-1"}},
      {"segments", {"0", "2.0", "1e1", "99999999999"}},
      {"opacity-unit", {"0", "auto"}},
      {"pixel-samples", {"0", "4097"}},
      {"extinction", {"-0.1", "Auto"}},
      {"camera-up", {"0,1", "1,2,3,", "1,2,3,4", "1,,3", "1 2 3", "1,2,nan"}},
      {"resolution", {"0x5", "5x0", "5x5x5", "5.5x5", "-5x5", "5X5"}},
      {"fov", {"0"}},
      {"aperture", {"0"}},
      {"ortho-width", {"0"}},
      {"background", {"-1,0,0"}},
      {"device", {"-2"}},
      {"sampling", {"cell"}},
      {"filter", {""}},
      {"light", {"", "1,2", "1,2,3,", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,4,-5,6", "1,2,nan"}},
      {"albedo", {"1.1", "-0.1", "0.5,0.5", "0.5,0.5,1.5"}},
      {"phase-g", {"-1"}},
      {"emission-scale", {"-1"}},
      {"temperature-scale", {"-1"}},
      {"connectivity", {"5", "27"}},
      {"mode", {"xrays"}},
      {"classification", {"none"}},
      {"end-corrections", {"0"}}};
  for (const auto& [name, texts] : bad)
    for (const char* text : texts)
      EXPECT_NE(refusal(name, text), "no error") << name << " " << text;
}

TEST(Json, RoundTripsEveryBit) {
  std::mt19937_64 random(7);
  const auto number = [&] {
    for (;;) {
      const double value = std::bit_cast<double>(random());
      if (std::abs(value) <= std::numeric_limits<float>::max()) return std::abs(value);
    }
  };
  for (int i = 0; i < 2000; ++i) {
    Scene scene;
    scene.input = "a \"quoted\" \\ name\n.vdb";
    scene.extinction = number();
    scene.luminance = {number(), 0.1 * i, 1.0 / 3};
    scene.camera_position = glm::dvec3(-number(), number(), -0.0);
    scene.early_termination = 1.0 / (i + 3);
    scene.memory_limit = random();
    scene.step = number() + 1e-300;
    scene.range = MapRange({-number(), 50 + i % 50}, {false, i % 3 == 0});
    scene.opacity = OpacityCurve{{{0, number()}, {1.0 / (i + 2), 0}, {1, number()}}};
    scene.lights = {{{-number(), 1.0 / (i + 7), -0.0}, {number(), 0, 1}}};
    scene.mode = static_cast<Mode>(i % 6);
    scene.end_corrections = i % 2 == 0;
    const Scene back = scene_from_json(to_json(scene));
    ASSERT_EQ(back.input, scene.input);
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
    ASSERT_EQ(bits(*back.extinction), bits(*scene.extinction));
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(bits((*back.luminance)[c]), bits((*scene.luminance)[c]));
      ASSERT_EQ(bits((*back.camera_position)[c]), bits((*scene.camera_position)[c]));
    }
    ASSERT_EQ(bits(*back.early_termination), bits(*scene.early_termination));
    ASSERT_EQ(bits(*back.step), bits(*scene.step));
    ASSERT_EQ(back.range, scene.range);
    ASSERT_EQ(back.opacity, scene.opacity);
    ASSERT_EQ(back.lights, scene.lights);
    ASSERT_EQ(back.mode, scene.mode);
    ASSERT_EQ(back.end_corrections, scene.end_corrections);
    ASSERT_EQ(back.memory_limit, scene.memory_limit);
    ASSERT_EQ(to_json(back), to_json(scene));
  }
}

TEST(Json, TakesTheCommandLinesSyntaxAndPartialScenes) {
  const Scene scene = scene_from_json(
      R"({"step": "0.25", "resolution": "64x32", "camera-up": "0,0,1", "memory-limit": "1G",
          "extinction": 2, "strict": true, "range": "0,1", "light": [1, 0, 0],
          "colormap": "gray"})");
  EXPECT_EQ(scene.step, 0.25);
  EXPECT_EQ(scene.resolution, glm::ivec2(64, 32));
  EXPECT_EQ(scene.camera_up, glm::dvec3(0, 0, 1));
  EXPECT_EQ(scene.memory_limit, 1u << 30);
  EXPECT_EQ(scene.extinction, 2.0);
  EXPECT_TRUE(scene.strict);
  EXPECT_EQ(scene.range, glm::dvec2(0, 1));
  EXPECT_EQ(scene.lights, (std::vector<DirectionalLight>{{{1, 0, 0}, glm::dvec3(1)}}));
  EXPECT_EQ(scene.colormap, Colormap::gray);
  EXPECT_EQ(scene.segments, 2);
}

TEST(Json, RefusesWithTheSourcesName) {
  const auto error = [](const char* text) {
    return usage_error([&] { scene_from_json(text, "a.json"); });
  };
  EXPECT_EQ(error(R"({"camera_position": [1,2,3]})"),
            "a.json: unknown parameter 'camera_position'; did you mean camera-position?");
  EXPECT_EQ(error(R"({"segments": 2.5})"),
            "a.json: --segments '2.5': expected a whole number from 1 to 64");
  EXPECT_EQ(error("[1]"), "a.json: not a scene: expected a JSON object of parameters");
  EXPECT_EQ(error("{").find("a.json: not a scene in JSON: "), 0u);
  EXPECT_EQ(error("").find("a.json: not a scene in JSON: "), 0u);
  EXPECT_EQ(error(R"({"grid": 5})"), "a.json: grid: expected a string");
  EXPECT_EQ(error(R"({"volumes": [1]})"),
            "a.json: volumes: expected a string or an array of strings");
  for (const char* bad :
       {R"({"camera-up": [1,2]})", R"({"camera-up": [1,2,[3]]})", R"({"camera-up": {"x":1}})",
        R"({"camera-up": ["0","1","0"]})", R"({"step": null})", R"({"step": [1]})",
        R"({"step": 1e999})", R"({"strict": 1})", R"({"step": true})", R"({"resolution": [5]})",
        R"({"memory-limit": -5})", R"({"integrator": 3})", R"({"range": [1]})", R"({"range": 1})",
        R"({"light": [1,2,3,4]})", R"({"transfer-function": {"points": []}})"})
    EXPECT_NE(error(bad), "no error") << bad;
}

}  // namespace
}  // namespace psivox
