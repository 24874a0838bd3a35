// Colour maps exported by ParaView: the values between their points, by VTK's definitions.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "base/text_file.h"
#include "scene/color.h"
#include "scene/transfer_function.h"
#include "thrown.h"

namespace psivox {
namespace {

/// `members` of the list's only object.
TransferFunction map(const std::string& members) {
  return transfer_function_from_json(R"([{"Name": "m", "NanColor": [1, 1, 0], )" + members + "}]",
                                     "m.json");
}

TransferFunction red_to_blue(const std::string& space) {
  return map(R"("RGBPoints": [0, 1, 0, 0, 1, 0, 0, 1], "ColorSpace": ")" + space + "\"");
}

/// 8-bit display colours; the bound is half a step for the knots and half for the published
/// rounding.
void expect_color(const TransferFunction& f, double value, const glm::dvec3& code) {
  const glm::dvec3 ours = 255.0 * srgb_from_linear(f.at(value).color);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours[c], code[c], 1) << value << " channel " << c;
}

TEST(ParaviewMap, KnowsTheColorSpaces) {
  expect_color(red_to_blue("Lab"), 0.5, {202, 0, 136});
  expect_color(map(R"("RGBPoints": [2, 0, 0, 0, 4, 1, 1, 1], "ColorSpace": "Lab")"), 3,
               {119, 119, 119});  // L* = 50
  expect_color(red_to_blue("HSV"), 0.25, {255, 255, 0});
  expect_color(red_to_blue("HSV"), 0.5, {0, 255, 0});
  const TransferFunction wrapped =
      map(R"("RGBPoints": [0, 1, 0, 0, 1, 0, 0, 1], "ColorSpace": "HSV", "HSVWrap": 1)");
  expect_color(wrapped, 0.5, {255, 0, 255});
  const TransferFunction cool_to_warm =
      map(R"("ColorSpace": "Diverging", "RGBPoints": [-1, 0.231373, 0.298039, 0.752941,
                                                      1, 0.705882, 0.0156863, 0.14902])");
  expect_color(cool_to_warm, 0, {221, 221, 221});
  for (double v = -1; v <= 1; v += 0.01) {
    // The same curve; each may use different points, half a step off it.
    expect_color(cool_to_warm, v,
                 255.0 * srgb_from_linear(colormap_color(Colormap::coolwarm, (v + 1) / 2)));
  }
}

TEST(ParaviewMap, IsWhatParaViewItselfMakesOfIt) {
  const std::string files = PSIVOX_ASSETS "/../tests/recorded/paraview-5.11-";
  std::istringstream rows(read_text(files + "maps.txt", "recorded"));
  std::string map;
  int count = 0;
  for (double value, r, g, b, opacity; rows >> map >> value >> r >> g >> b >> opacity; ++count) {
    const TransferFunction f = read_transfer_function(files + map + ".json");
    expect_color(f, value, 255.0 * glm::dvec3(r, g, b));
    EXPECT_NEAR(f.at(value).attenuation, opacity, 1.0 / 510) << map << " " << value;
  }
  EXPECT_EQ(count, 4 * 24);
}

TEST(ParaviewMap, StepsToTheColorOfTheUpperPoint) {
  const TransferFunction f =
      map(R"("ColorSpace": "Step", "RGBPoints": [0, 1,0,0, 1, 0,1,0, 2, 0,0,1])");
  expect_color(f, 0, {255, 0, 0});
  expect_color(f, 0.001, {0, 255, 0});
  expect_color(f, 0.5, {0, 255, 0});
  expect_color(f, 1, {0, 255, 0});
  expect_color(f, 1.001, {0, 0, 255});
  expect_color(f, 5, {0, 0, 255});
}

TEST(ParaviewMap, AttenuatesByOpacityAtPointsOfBothLists) {
  const TransferFunction f = map(
      R"("RGBPoints": [0, 0.2,0.2,0.2, 4, 0.2,0.2,0.2],
         "Points": [-1, 0, 0.5, 0,  1, 0.5, 0.5, 0,  1, 0.75, 0.5, 0,  5, 1, 0.5, 0])");
  EXPECT_EQ(f.at(-2).attenuation, 0);
  EXPECT_EQ(f.at(0).attenuation, 0.25);
  EXPECT_EQ(f.at(1).attenuation, 0.5);
  EXPECT_EQ(f.at(std::nextafter(1.0f, 2.0f)).attenuation, 0.75);
  EXPECT_NEAR(f.at(3).attenuation, 0.875, 1e-7);  // the jump is one float32 step wide
  EXPECT_EQ(f.at(9).attenuation, 1);
  for (double v = -2; v < 6; v += 0.1) expect_color(f, v, {51, 51, 51});
  EXPECT_EQ(f.points().size(), 6u);
}

TEST(ParaviewMap, RampsWithoutOpacity) {
  const TransferFunction f = map(R"("RGBPoints": [2, 0,0,0, 3, 1,0,0, 6, 1,1,1])");
  EXPECT_EQ(f.at(1).attenuation, 0);
  EXPECT_NEAR(f.at(3).attenuation, 0.25, 1e-15);
  EXPECT_NEAR(f.at(5).attenuation, 0.75, 1e-15);
  EXPECT_EQ(f.at(7).attenuation, 1);
}

TEST(ParaviewMap, BendsOpacityByMidpointAndSharpness) {
  const auto with = [](double midpoint, double sharpness) {
    return map(R"("RGBPoints": [0, 1,1,1, 1, 1,1,1], "Points": [0, 0.2, )" +
               std::to_string(midpoint) + ", " + std::to_string(sharpness) + ", 1, 0.8, 0.5, 0]");
  };
  const TransferFunction bent = with(0.25, 0);
  EXPECT_EQ(bent.points().size(), 3u);
  EXPECT_NEAR(bent.at(0.25).attenuation, 0.5, 1e-15);
  EXPECT_NEAR(bent.at(0.125).attenuation, 0.35, 1e-15);
  EXPECT_NEAR(bent.at(0.625).attenuation, 0.65, 1e-15);

  const TransferFunction step = with(0.75, 1);
  EXPECT_EQ(step.points().size(), 4u);
  EXPECT_EQ(step.at(0.75).attenuation, 0.2);
  EXPECT_EQ(step.at(0.7500001).attenuation, 0.8);

  // vtkPiecewiseFunction::GetTable's formula at some places: s = 0.5 (2 t)^(1 + 10 sharpness), then
  // the Hermite basis with slope (1 - sharpness) (b - a) at both ends.
  for (const double sharpness : {0.1, 0.25, 0.5, 0.9}) {
    const TransferFunction curve = with(0.5, sharpness);
    EXPECT_LT(curve.points().size(), 80u);
    for (double t = 0.01; t < 1; t += 0.01) {
      const double power = 1 + 10 * sharpness;
      const double s =
          t < 0.5 ? 0.5 * std::pow(2 * t, power) : 1 - 0.5 * std::pow(2 * (1 - t), power);
      const double s2 = s * s, s3 = s2 * s, slope = (1 - sharpness) * 0.6;
      const double value = (2 * s3 - 3 * s2 + 1) * 0.2 + (-2 * s3 + 3 * s2) * 0.8 +
                           (s3 - 2 * s2 + s) * slope + (s3 - s2) * slope;
      // 1/510 of the height, 0.6: the points are chosen to meet this, checked at eighths of a part
      EXPECT_NEAR(curve.at(t).attenuation, value, 1.1 * 0.6 / 510) << sharpness << " " << t;
    }
  }
}

TEST(ParaviewMap, RefusesInOneLine) {
  const auto error = [](const std::string& text) {
    return input_error([&] { transfer_function_from_json(text, "m.json"); });
  };
  const std::string points = R"("RGBPoints": [0,0,0,0, 1,1,1,1])";
  EXPECT_EQ(error("[]"), "m.json: holds 0 colour maps; export one alone");
  EXPECT_EQ(error("[{" + points + "},{" + points + "}]"),
            "m.json: holds 2 colour maps; export one alone");
  EXPECT_EQ(error("[3]").find("m.json: not a transfer function: "), 0u);
  EXPECT_EQ(error(R"([{"ColorSpace": "RGB"}])"), "m.json: the colour map has no RGBPoints");
  EXPECT_EQ(error(R"([{"IndexedColors": [1,1,1]}])"),
            "m.json: a categorical map (IndexedColors) is no function of a value");
  EXPECT_EQ(error(R"([{"RGBPoints": [0,0,0]}])"),
            "m.json: RGBPoints: expected groups of four numbers");
  EXPECT_EQ(error(R"([{"RGBPoints": [0,0,0,"0"]}])"),
            "m.json: RGBPoints: expected groups of four numbers");
  EXPECT_EQ(error(R"([{"RGBPoints": [0,0,0,1.5]}])"), "m.json: RGBPoints: 1.5 is not from 0 to 1");
  EXPECT_EQ(error(R"([{"RGBPoints": [1,0,0,0, 0,1,1,1]}])"),
            "m.json: RGBPoints: values must ascend, but 0 follows 1");
  EXPECT_EQ(error("[{" + points + R"(, "Points": [0, -1, 0.5, 0]}])"),
            "m.json: Points: -1 is not from 0 to 1");
  EXPECT_EQ(error("[{" + points + R"(, "ColorSpace": "Lab/CIEDE2000"}])"),
            "m.json: ColorSpace 'Lab/CIEDE2000': expected RGB, HSV, Lab, Diverging or Step");
  EXPECT_NE(error("[{" + points + R"(, "ColorSpace": 3}])"), "no error");
  EXPECT_NE(error("[{" + points + R"(, "UseLogScale": 1}])"), "no error");
  EXPECT_EQ(error("{" + points + R"(, "UseLogScale": 0})"), "no error");
}

}  // namespace
}  // namespace psivox
