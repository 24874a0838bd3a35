#include "scene/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "scene/paraview.h"

namespace psivox {
namespace {

constexpr double float_max = std::numeric_limits<float>::max();

[[noreturn]] void refuse(std::size_t index, const std::string& problem) {
  throw Error(ExitCode::input,
              "point " + std::to_string(index + 1) + " of the transfer function: " + problem);
}

void check_number(std::size_t index, const char* what, double number, double min) {
  if (!(std::abs(number) <= float_max))
    refuse(index, std::string(what) + " " + number_text(number) + " is no finite float32");
  if (number < min) refuse(index, std::string(what) + " " + number_text(number) + " is negative");
}

/// Throws Error(input) unless the points are what TransferFunction says.
void check(const std::vector<TransferPoint>& points) {
  if (points.empty()) throw Error(ExitCode::input, "the transfer function has no points");
  for (std::size_t i = 0; i < points.size(); ++i) {
    check_number(i, "value", points[i].value, -float_max);
    check_number(i, "attenuation", points[i].attenuation, 0);
    for (int c = 0; c < 3; ++c) check_number(i, "color", points[i].color[c], 0);
    if (i > 0 && points[i].value < points[i - 1].value)
      refuse(i, "values must ascend, but " + number_text(points[i].value) + " follows " +
                    number_text(points[i - 1].value));
    if (i > 1 && points[i].value == points[i - 2].value)
      refuse(i, "a third point of value " + number_text(points[i].value) +
                    "; a jump is two points of one value");
  }
}

/// std::lerp is exact at both ends, monotonic, and exact between equals: despite rounding, no value
/// lies beyond those at the ends.
TransferPoint between(const TransferPoint& a, const TransferPoint& b, double value) {
  const double t = (value - a.value) / (b.value - a.value);
  TransferPoint p{value, std::lerp(a.attenuation, b.attenuation, t), {}};
  for (int c = 0; c < 3; ++c) p.color[c] = std::lerp(a.color[c], b.color[c], t);
  return p;
}

}  // namespace

TransferFunction::TransferFunction(std::vector<TransferPoint> points, bool has_color,
                                   GradientPart gradient_part)
    : points_(std::move(points)), has_color_(has_color), part_(std::move(gradient_part)) {
  place_gradient_part();
  check(points_);
  // Two values that round to one float32 are a jump as well; the later one moves up.
  for (std::size_t i = 0; i < points_.size(); ++i) {
    float value = static_cast<float>(points_[i].value) + 0.0f;  // not -0
    if (i > 0 && !(value > points_[i - 1].value))
      value = std::nextafter(static_cast<float>(points_[i - 1].value),
                             std::numeric_limits<float>::infinity());
    if (!std::isfinite(value)) refuse(i, "no float32 is left above the value before it");
    points_[i].value = value;
  }
  integrals_.resize(points_.size());
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const TransferPoint &a = points_[i - 1], &b = points_[i];
    integrals_[i] = integrals_[i - 1] + (b.value - a.value) * 0.5 * (a.attenuation + b.attenuation);
  }
}

TransferFunction TransferFunction::attenuation_alone() const {
  double most = 0;
  for (const TransferPoint& point : points_) most = std::max(most, point.attenuation);
  const double rounding = std::ldexp(most, -23);
  std::vector<TransferPoint> kept;
  for (std::size_t i = 0; i < points_.size();) {
    kept.push_back({points_[i].value, points_[i].attenuation});
    // slopes of the lines from here that pass all points so far
    double least = -HUGE_VAL, greatest = HUGE_VAL;
    std::size_t next = i + 1;
    for (std::size_t k = i + 1; k < points_.size(); ++k) {
      const double width = points_[k].value - points_[i].value;
      const double rise = points_[k].attenuation - points_[i].attenuation;
      if (rise < least * width || rise > greatest * width) break;
      next = k;
      least = std::max(least, (rise - rounding) / width);
      greatest = std::min(greatest, (rise + rounding) / width);
      // a table of gradients has a row for each point
      if (!part_.gradients.empty()) break;
    }
    i = next;
  }
  return TransferFunction(std::move(kept), false, part_);
}

int TransferFunction::interval(double value) const {
  const auto above =
      std::upper_bound(points_.begin(), points_.end(), value,
                       [](double v, const TransferPoint& point) { return v < point.value; });
  return static_cast<int>(above - points_.begin()) - 1;
}

TransferPoint TransferFunction::at(double value) const {
  const int k = interval(value);
  const auto below = static_cast<std::size_t>(std::max(k, 0)), above = below + 1;
  if (k >= 0 && above < points_.size()) return between(points_[below], points_[above], value);
  TransferPoint point = points_[below];
  point.value = value;
  return point;
}

double TransferFunction::max_attenuation(double min_value, double max_value) const {
  double most = std::max(at(min_value).attenuation, at(max_value).attenuation);
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = std::max(most, points_[static_cast<std::size_t>(k)].attenuation);
  return most;
}

glm::dvec3 TransferFunction::max_color(double min_value, double max_value) const {
  glm::dvec3 most = glm::max(at(min_value).color, at(max_value).color);
  for (int k = interval(min_value) + 1; k <= interval(max_value); ++k)
    most = glm::max(most, points_[static_cast<std::size_t>(k)].color);
  return most;
}

double TransferFunction::attenuation_integral(double value) const {
  const auto k = static_cast<std::size_t>(std::max(interval(value), 0));
  const double mean = 0.5 * (points_[k].attenuation + at(value).attenuation);
  return integrals_[k] + (value - points_[k].value) * mean;
}

namespace {

using nlohmann::json;

[[noreturn]] void fail_at(const std::string& what) { throw Error(ExitCode::input, what); }

void check_keys(const json& object, const std::vector<std::string>& known,
                const std::string& where) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    fail_at(where + ": unknown key " + in_quotes(key) + suggestion(key, known));
  }
}

double number(const json& value, const std::string& where) {
  if (!value.is_number()) fail_at(where + ": expected a number");
  return value.get<double>();
}

double required_number(const json& object, const char* key, const std::string& where) {
  if (!object.contains(key)) fail_at(where + ": has no " + key);
  return number(object[key], where + ": " + key);
}

/// Reads a point and appends its attenuations at all gradients to the table; the point has one or
/// as many as there are gradients.
TransferPoint read_point(const json& object, const std::string& where, GradientPart& part) {
  if (!object.is_object()) fail_at(where + ": expected an object of value, attenuation and color");
  check_keys(object, {"value", "attenuation", "color"}, where);
  TransferPoint point;
  point.value = required_number(object, "value", where);
  if (!object.contains("attenuation") || !object["attenuation"].is_array()) {
    point.attenuation = required_number(object, "attenuation", where);
    part.attenuation.insert(part.attenuation.end(), part.gradients.size(), point.attenuation);
  } else {
    const json& row = object["attenuation"];
    if (row.size() != part.gradients.size())
      fail_at(where + ": attenuation: has " + std::to_string(row.size()) + " numbers for " +
              std::to_string(part.gradients.size()) + " gradients");
    for (const json& item : row) part.attenuation.push_back(number(item, where + ": attenuation"));
  }
  if (!object.contains("color")) return point;
  const json& color = object["color"];
  if (!color.is_array() || color.size() != 3) fail_at(where + ": color: expected [r, g, b]");
  for (std::size_t c = 0; c < 3; ++c)
    point.color[static_cast<int>(c)] = number(color[c], where + ": color");
  return point;
}

const json& array_of(const json& object, const char* key) {
  if (!object[key].is_array()) fail_at(std::string(key) + ": expected an array");
  return object[key];
}

GradientPart read_gradient_part(const json& object) {
  GradientPart part;
  if (object.contains("gradients")) {
    for (const json& item : array_of(object, "gradients"))
      part.gradients.push_back(number(item, "gradients"));
    if (part.gradients.empty()) fail_at("gradients: expected at least one");
  }
  if (!object.contains("isosurfaces")) return part;
  for (const json& item : array_of(object, "isosurfaces")) {
    const std::string where =
        "isosurface " + std::to_string(part.isosurfaces.size() + 1) + " of the transfer function";
    if (!item.is_object())
      fail_at(where + ": expected an object of value, thickness and attenuation");
    check_keys(item, {"value", "thickness", "attenuation"}, where);
    part.isosurfaces.push_back({required_number(item, "value", where),
                                required_number(item, "thickness", where),
                                required_number(item, "attenuation", where)});
  }
  return part;
}

TransferFunction read_points(const json& object) {
  check_keys(object, {"points", "gradients", "isosurfaces"}, "the transfer function");
  GradientPart part = read_gradient_part(object);
  if (!object.contains("points") && !part.isosurfaces.empty() && part.gradients.empty())
    return TransferFunction({TransferPoint{}}, false, std::move(part));
  if (!object.contains("points")) fail_at("the transfer function has no points");
  std::vector<TransferPoint> points;
  std::size_t colors = 0;
  for (const json& item : array_of(object, "points")) {
    points.push_back(read_point(
        item, "point " + std::to_string(points.size() + 1) + " of the transfer function", part));
    if (item.contains("color")) ++colors;
  }
  if (colors != 0 && colors != points.size())
    fail_at("some points of the transfer function have a color and some have none; give it to all");
  return TransferFunction(std::move(points), colors != 0, std::move(part));
}

TransferFunction read(std::string_view text) {
  json document;
  try {
    document = json::parse(text);
  } catch (const json::exception& error) {
    fail_at("not a transfer function in JSON: " + std::string(error.what()));
  }
  if (document.is_array()) {
    if (document.size() != 1)
      fail_at("holds " + std::to_string(document.size()) + " colour maps; export one alone");
    document = json(document[0]);
  }
  if (!document.is_object()) fail_at("not a transfer function: expected a JSON object of points");
  const bool paraview = document.contains("RGBPoints") || document.contains("ColorSpace") ||
                        document.contains("IndexedColors");
  return paraview ? transfer_function_from_paraview(document) : read_points(document);
}

}  // namespace

TransferFunction transfer_function_from_json(std::string_view text, std::string_view source) {
  try {
    return read(text);
  } catch (const Error& error) {
    throw Error(error.code(), std::string(source) + ": " + error.what());
  }
}

namespace {

std::string array_text(std::span<const double> numbers) {
  std::string out;
  for (const double x : numbers) out += (out.empty() ? "[" : ", ") + number_text(x);
  return out + "]";
}

/// A float32 number, with just enough digits to give the same float32.
std::string float_text(double number) { return number_text(static_cast<float>(number)); }

}  // namespace

std::string to_json(const TransferFunction& function) {
  const GradientPart& part = function.gradient_part();
  std::string out = "{";
  if (!part.gradients.empty()) {
    std::string list;
    for (const double g : part.gradients) list += (list.empty() ? "" : ", ") + float_text(g);
    out += "\"gradients\": [" + list + "],\n ";
  }
  if (!part.isosurfaces.empty()) {
    std::string list;
    for (const Isosurface& s : part.isosurfaces)
      list += (list.empty() ? "\n" : ",\n") + ("  {\"value\": " + float_text(s.value)) +
              ", \"thickness\": " + number_text(s.thickness) +
              ", \"attenuation\": " + number_text(s.attenuation) + "}";
    out += "\"isosurfaces\": [" + list + "\n],\n ";
  }
  std::string list;
  const std::size_t columns = part.gradients.size();
  for (std::size_t k = 0; k < function.points().size(); ++k) {
    const TransferPoint& p = function.points()[k];
    list += (list.empty() ? "\n" : ",\n") + ("  {\"value\": " + float_text(p.value)) +
            ", \"attenuation\": " +
            (columns == 0 ? number_text(p.attenuation)
                          : array_text(std::span(part.attenuation).subspan(k * columns, columns)));
    if (function.has_color())
      list += ", \"color\": [" + number_text(p.color.r) + ", " + number_text(p.color.g) + ", " +
              number_text(p.color.b) + "]";
    list += "}";
  }
  return out + "\"points\": [" + list + "\n]}\n";
}

TransferFunction read_transfer_function(const std::filesystem::path& path) {
  const std::string name = path.string();
  return transfer_function_from_json(read_text(name, "transfer function"), name);
}

}  // namespace psivox
