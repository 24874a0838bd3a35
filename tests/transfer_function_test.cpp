// Transfer functions: the knots, the values between them, and their file.

#include "scene/transfer_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "march/transfer_table.h"
#include "thrown.h"

namespace psivox {
namespace {

/// A hat of attenuation with a colour that changes by jumps at 1.
TransferFunction example() {
  return TransferFunction({{-1, 0, {0, 0, 1}},
                           {1, 4, {0, 1, 0}},
                           {1, 2, {1, 0, 0}},
                           {3, 0, {1, 1, 1}},
                           {4, 0.5, {0, 0, 0}}});
}

TransferFunction random_function(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<TransferPoint> points;
  double value = -2;
  for (int i = 0; i < 9; ++i) {
    value += uniform(random) * uniform(random);
    points.push_back({value, uniform(random), {uniform(random), uniform(random), uniform(random)}});
  }
  return TransferFunction(points);
}

TEST(TransferFunction, IsLinearBetweenPointsAndConstantOutside) {
  const TransferFunction f = example();
  EXPECT_EQ(f.at(-7).attenuation, 0);
  EXPECT_EQ(f.at(-7).color, glm::dvec3(0, 0, 1));
  EXPECT_EQ(f.at(-7).value, -7);
  EXPECT_EQ(f.at(-0.5).attenuation, 1);
  EXPECT_EQ(f.at(0).color, glm::dvec3(0, 0.5, 0.5));
  EXPECT_EQ(f.at(1).attenuation, 4);  // at a jump the first point's value counts
  EXPECT_EQ(f.at(1).color, glm::dvec3(0, 1, 0));
  EXPECT_EQ(f.at(std::nextafter(1.0f, 2.0f)).attenuation, 2);
  EXPECT_EQ(f.at(3.5).attenuation, 0.25);
  EXPECT_EQ(f.at(9).attenuation, 0.5);
  for (const TransferPoint& point : f.points()) EXPECT_EQ(f.at(point.value), point);
}

TEST(TransferFunction, StoresFloatsAndWidensJumpsToOneStep) {
  const TransferFunction f({{0.1, 1, {}}, {0.3, 1, {}}, {0.3, 2, {}}, {-0.0 + 0.5, 2, {}}});
  EXPECT_EQ(f.points()[0].value, static_cast<double>(0.1f));
  EXPECT_EQ(f.points()[1].value, static_cast<double>(0.3f));
  EXPECT_EQ(f.points()[2].value, static_cast<double>(std::nextafter(0.3f, 1.0f)));
  // Distinct doubles that are one float32, and a jump whose neighbour is the next float32.
  const float next = std::nextafter(1.0f, 2.0f);
  const TransferFunction g({{1, 1, {}}, {1 + 1e-12, 2, {}}, {next, 3, {}}, {2, 4, {}}});
  EXPECT_EQ(g.points()[1].value, static_cast<double>(next));
  EXPECT_EQ(g.points()[2].value, static_cast<double>(std::nextafter(next, 2.0f)));
  EXPECT_EQ(g.points()[2].attenuation, 3);
  EXPECT_FALSE(std::signbit(TransferFunction({{-0.0, 1, {}}}).points()[0].value));
}

TEST(TransferRamps, SumUpToTheAttenuation) {
  const TransferFunction function({{-1, 0.25}, {0.5, 0.25}, {1, 0.5}, {3, 0.75}});
  const std::optional<Ramps> ramps = make_ramps(function);
  ASSERT_TRUE(ramps);
  for (double v = -2; v < 4; v += 0.01) {
    double sum = ramps->base;
    for (int i = 0; i < 4; ++i) sum += ramps->slopes[i] * std::max(v - ramps->knots[i], 0.0);
    EXPECT_NEAR(sum, function.at(v).attenuation, 1e-14) << v;
  }
  // four bends at most; none that falls; no jump, whose ramps would cancel
  EXPECT_FALSE(make_ramps(TransferFunction({{0, 0}, {1, 1}, {2, 3}, {3, 4}, {4, 7}})));
  EXPECT_FALSE(make_ramps(TransferFunction({{0, 0}, {1, 1}, {2, 0}})));
  EXPECT_FALSE(make_ramps(TransferFunction({{0, 0}, {1, 0}, {1, 1}, {2, 1}})));
}

TEST(TransferFunction, RefusesWhatItSays) {
  const auto error = [](std::vector<TransferPoint> points) {
    return input_error([&] { TransferFunction{std::move(points)}; });
  };
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error({}), "the transfer function has no points");
  EXPECT_EQ(error({{1, 0, {}}, {0.5, 0, {}}}),
            "point 2 of the transfer function: values must ascend, but 0.5 follows 1");
  EXPECT_EQ(error({{1, -2, {}}}), "point 1 of the transfer function: attenuation -2 is negative");
  EXPECT_EQ(error({{1, 0, {1, 1, -1}}}), "point 1 of the transfer function: color -1 is negative");
  EXPECT_EQ(error({{1, 0, {}}, {1, 1, {}}, {1, 2, {}}}),
            "point 3 of the transfer function: a third point of value 1; a jump is two points of "
            "one value");
  for (const double bad : {inf, -inf, std::nan(""), 1e39}) {
    EXPECT_NE(error({{bad, 0, {}}}), "no error");
    EXPECT_NE(error({{0, bad, {}}}), "no error");
    EXPECT_NE(error({{0, 0, {0, bad, 0}}}), "no error");
  }
  const double most = std::numeric_limits<float>::max();
  EXPECT_NE(error({{most, 0, {}}, {most, 1, {}}}), "no error");
}

TEST(TransferFunctionJson, ReadsPointsWithAndWithoutColor) {
  const TransferFunction f = transfer_function_from_json(
      R"({"points": [{"value": -1, "attenuation": 0, "color": [0, 0.5, 1]},
                     {"color": [1, 1, 1], "value": 2.5, "attenuation": 1e-3}]})",
      "a.json");
  EXPECT_TRUE(f.has_color());
  ASSERT_EQ(f.points().size(), 2u);
  EXPECT_EQ(f.points()[0].color, glm::dvec3(0, 0.5, 1));
  EXPECT_EQ(f.points()[1].value, 2.5);
  EXPECT_EQ(f.points()[1].attenuation, 1e-3);
  const TransferFunction grey =
      transfer_function_from_json(R"({"points": [{"value": 0, "attenuation": 1}]})", "a.json");
  EXPECT_FALSE(grey.has_color());
  EXPECT_EQ(grey.points()[0].color, glm::dvec3(1));
}

TEST(TransferFunctionJson, RoundTripsEveryBit) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const TransferFunction f = random_function(random);
    EXPECT_EQ(transfer_function_from_json(to_json(f), "a.json"), f) << to_json(f);
    const TransferFunction grey(f.points(), false);
    const TransferFunction back = transfer_function_from_json(to_json(grey), "a.json");
    EXPECT_FALSE(back.has_color());
    for (std::size_t k = 0; k < f.points().size(); ++k)
      EXPECT_EQ(back.points()[k].attenuation, f.points()[k].attenuation);
  }
  const TransferFunction f = example();
  EXPECT_EQ(transfer_function_from_json(to_json(f), "a.json"), f);
  EXPECT_TRUE(has(to_json(TransferFunction({{0.1, 0.2, {}}})), "\"value\": 0.1,"));
}

TEST(TransferFunctionJson, RefusesInOneLineWithTheSourcesName) {
  const auto error = [](const std::string& text) {
    return input_error([&] { transfer_function_from_json(text, "a.json"); });
  };
  const auto point_error = [&](const std::string& point) {
    return error(R"({"points": [{"value": 0, "attenuation": 1}, )" + point + "]}");
  };
  const std::string point = "a.json: point 2 of the transfer function: ";
  EXPECT_EQ(error("{").find("a.json: not a transfer function in JSON: "), 0u);
  EXPECT_EQ(error("").find("a.json: not a transfer function in JSON: "), 0u);
  EXPECT_EQ(error("3").find("a.json: not a transfer function: "), 0u);
  EXPECT_EQ(error("{}"), "a.json: the transfer function has no points");
  EXPECT_EQ(error(R"({"points": []})"), "a.json: the transfer function has no points");
  EXPECT_EQ(error(R"({"points": 3})"), "a.json: points: expected an array");
  EXPECT_EQ(error(R"({"pionts": []})"),
            "a.json: the transfer function: unknown key 'pionts'; did you mean points?");
  EXPECT_EQ(point_error("7"), point + "expected an object of value, attenuation and color");
  EXPECT_EQ(point_error(R"({"value": 1})"), point + "has no attenuation");
  EXPECT_EQ(point_error(R"({"value": "1", "attenuation": 0})"), point + "value: expected a number");
  EXPECT_EQ(point_error(R"({"value": 1, "attenuation": 0, "colour": [1,1,1]})"),
            point + "unknown key 'colour'; did you mean color?");
  EXPECT_EQ(point_error(R"({"value": 1, "attenuation": -1})"),
            point + "attenuation -1 is negative");
  EXPECT_EQ(point_error(R"({"value": -1, "attenuation": 1})"),
            point + "values must ascend, but -1 follows 0");
  EXPECT_EQ(point_error(R"({"value": 1, "attenuation": 1, "color": [1, 1]})"),
            point + "color: expected [r, g, b]");
  EXPECT_EQ(point_error(R"({"value": 1, "attenuation": 1, "color": [1, 1, null]})"),
            point + "color: expected a number");
  EXPECT_EQ(point_error(R"({"value": 1, "attenuation": 1, "color": [1, 1, 1]})"),
            "a.json: some points of the transfer function have a color and some have none; give it "
            "to all");
  EXPECT_NE(point_error(R"({"value": 1e999, "attenuation": 1})"), "no error");
}

TEST(TransferFunctionFile, NamesTheFileThatItCannotRead) {
  const auto error = [](const char* path) {
    return input_error([&] { read_transfer_function(path); });
  };
  EXPECT_EQ(error("nope.json"),
            "cannot read transfer function 'nope.json': No such file or directory");
  EXPECT_EQ(error("/"), "cannot read transfer function '/': Is a directory");
}

}  // namespace
}  // namespace psivox
