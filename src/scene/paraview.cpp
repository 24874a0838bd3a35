#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/text.h"
#include "psivox/error.h"
#include "scene/color.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::string& what) { throw Error(ExitCode::input, what); }

/// The groups of four numbers of `key`. The first numbers ascend; the others are in [0, 1].
std::vector<std::array<double, 4>> read_groups(const json& object, const char* key) {
  const json& list = object[key];
  const std::string name = key;
  if (!list.is_array() || list.empty() || list.size() % 4 != 0)
    fail(name + ": expected groups of four numbers");
  std::vector<std::array<double, 4>> groups(list.size() / 4);
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (!list[i].is_number()) fail(name + ": expected groups of four numbers");
    const double number = list[i].get<double>();
    if (i % 4 != 0 && !(number >= 0 && number <= 1))
      fail(name + ": " + number_text(number) + " is not from 0 to 1");
    groups[i / 4][i % 4] = number;
  }
  for (std::size_t i = 1; i < groups.size(); ++i) {
    if (groups[i][0] < groups[i - 1][0])
      fail(name + ": values must ascend, but " + number_text(groups[i][0]) + " follows " +
           number_text(groups[i - 1][0]));
  }
  return groups;
}

bool is_set(const json& object, const char* key) {
  if (!object.contains(key)) return false;
  const json& value = object[key];
  return value.is_boolean() ? value.get<bool>() : value.is_number() && value.get<double>() != 0;
}

// ---- points of the colour alone, two of the same value at a jump ----

using Mix = std::function<glm::dvec3(const glm::dvec3&, const glm::dvec3&, double)>;

Mix color_mix(const json& object, const std::string& space) {
  const bool shortest = is_set(object, "HSVWrap");
  if (space == "RGB")
    return [](const glm::dvec3& a, const glm::dvec3& b, double t) { return glm::mix(a, b, t); };
  if (space == "HSV" || space == "HSVNoWrap")
    return [shortest](const glm::dvec3& a, const glm::dvec3& b, double t) {
      return mix_hsv(a, b, t, shortest);
    };
  if (space == "Lab") return mix_lab;
  if (space == "Diverging") return mix_diverging;
  if (space == "Step") return [](const glm::dvec3&, const glm::dvec3& b, double) { return b; };
  fail("ColorSpace " + in_quotes(space) + ": expected RGB, HSV, Lab, Diverging or Step");
}

std::vector<TransferPoint> read_colors(const json& object) {
  if (!object.contains("RGBPoints"))
    fail(object.contains("IndexedColors")
             ? "a categorical map (IndexedColors) is no function of a value"
             : "the colour map has no RGBPoints");
  const json& space = object.value("ColorSpace", json("RGB"));
  if (!space.is_string()) fail("ColorSpace: expected a string");
  const Mix mix = color_mix(object, space.get<std::string>());
  const bool step = space == "Step";  // an interval has the colour of its upper end
  std::vector<TransferPoint> points;
  const auto add = [&](double value, const glm::dvec3& code) {
    points.push_back({value, 0, linear_from_srgb(code)});
  };
  double last_value = 0;
  glm::dvec3 last_code{0};
  for (const auto& [value, red, green, blue] : read_groups(object, "RGBPoints")) {
    const glm::dvec3 code{red, green, blue};
    if (!points.empty() && value > last_value) {
      const auto curve = [&](double t) { return mix(last_code, code, t); };
      if (step) add(last_value, code);
      for (const double t : color_knots(curve, 0, 1)) {
        if (t < 1) add(std::lerp(last_value, value, t), curve(t));
      }
    }
    add(value, code);
    last_value = value;
    last_code = code;
  }
  return points;
}

// ---- points of the opacity alone ----

/// vtkPiecewiseFunction between two nodes: the value passes the mean of theirs at `midpoint`;
/// sharpness bends a straight line (below 0.01) into a step (above 0.99).
double opacity_between(double a, double b, double t, double midpoint, double sharpness) {
  double s = t < midpoint ? 0.5 * t / midpoint : 0.5 + 0.5 * (t - midpoint) / (1 - midpoint);
  if (sharpness < 0.01) return std::lerp(a, b, s);
  const double power = 1 + 10 * sharpness;
  s = s < 0.5 ? 0.5 * std::pow(2 * s, power) : 1 - 0.5 * std::pow(2 - 2 * s, power);
  // A cubic Hermite curve with the same slope at both ends.
  const double slope = (1 - sharpness) * (b - a);
  const double value = std::lerp(a, b, s * s * (3 - 2 * s)) + slope * s * (1 - s) * (1 - 2 * s);
  return std::clamp(value, std::min(a, b), std::max(a, b));
}

/// Appends the points between two nodes.
void add_between(std::vector<TransferPoint>& points, const std::array<double, 4>& node,
                 const std::array<double, 4>& next) {
  const double value = node[0], opacity = node[1], sharpness = node[3];
  const double midpoint = std::clamp(node[2], 0.00001, 0.99999);  // VTK's bounds
  const auto add = [&](double t, double y) {
    points.push_back({std::lerp(value, next[0], t), y, {}});
  };
  if (sharpness > 0.99) {
    add(midpoint, opacity);
    add(midpoint, next[1]);
    return;
  }
  const auto curve = [&](double t) {
    return opacity_between(opacity, next[1], t, midpoint, sharpness);
  };
  const double tolerance = half_code<double> * std::abs(next[1] - opacity);
  const auto fits = [&](double a, double b) {
    for (int i = 1; i < 8; ++i) {
      const double t = std::lerp(a, b, i / 8.0);
      if (std::abs(std::lerp(curve(a), curve(b), i / 8.0) - curve(t)) > tolerance) return false;
    }
    return true;
  };
  if (fits(0, 1)) return;
  std::vector<double> places;
  append_parts(0, midpoint, fits, 9, places);
  append_parts(midpoint, 1, fits, 9, places);
  places.pop_back();
  for (const double t : places) add(t, curve(t));
}

std::vector<TransferPoint> read_opacities(const json& object,
                                          const std::vector<TransferPoint>& colors) {
  if (!object.contains("Points"))
    return {{colors.front().value, 0, {}}, {colors.back().value, 1, {}}};
  const auto nodes = read_groups(object, "Points");
  std::vector<TransferPoint> points;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    points.push_back({nodes[i][0], nodes[i][1], {}});
    if (i + 1 < nodes.size() && nodes[i + 1][0] > nodes[i][0])
      add_between(points, nodes[i], nodes[i + 1]);
  }
  return points;
}

// ---- both ----

/// The limit of the points' straight lines from below, or from above, at a value.
TransferPoint limit(const std::vector<TransferPoint>& points, double value, bool from_above) {
  const auto next = from_above ? std::ranges::upper_bound(points, value, {}, &TransferPoint::value)
                               : std::ranges::lower_bound(points, value, {}, &TransferPoint::value);
  if (next == points.begin()) return points.front();
  if (next == points.end()) return points.back();
  const TransferPoint &a = next[-1], &b = *next;
  const double t = (value - a.value) / (b.value - a.value);
  return {value, std::lerp(a.attenuation, b.attenuation, t), glm::mix(a.color, b.color, t)};
}

}  // namespace

TransferFunction transfer_function_from_paraview(const json& object) {
  if (is_set(object, "UseLogScale"))
    fail("a map over the logarithm of the value (UseLogScale) cannot be read; export it without");
  const std::vector<TransferPoint> colors = read_colors(object);
  const std::vector<TransferPoint> opacities = read_opacities(object, colors);
  std::vector<double> values;
  for (const auto* points : {&colors, &opacities})
    for (const TransferPoint& p : *points) values.push_back(p.value);
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<TransferPoint> merged;
  for (const double value : values) {
    const auto side = [&](bool from_above) {
      return TransferPoint{value, limit(opacities, value, from_above).attenuation,
                           limit(colors, value, from_above).color};
    };
    merged.push_back(side(false));
    if (side(true) != merged.back()) merged.push_back(side(true));
  }
  return TransferFunction(std::move(merged));
}

}  // namespace psivox
