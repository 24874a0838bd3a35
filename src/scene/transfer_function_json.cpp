#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "base/memory.h"
#include "base/text.h"
#include "base/text_file.h"
#include "psivox/error.h"
#include "scene/json_problem.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

using nlohmann::json;

[[noreturn]] void fail_at(const std::string& what) { throw Error(ExitCode::input, what); }

void check_keys(const json& object, const std::vector<std::string>& known,
                const std::string& where) {
  psivox::check_keys(object, known, where, ExitCode::input);
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
  for (std::size_t c = 0; c < 3; ++c) point.color[int(c)] = number(color[c], where + ": color");
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
  const json& items = array_of(object, "points");
  // in double, as the march's table of float32, and on its way to the device
  constexpr double entry_bytes = 56;
  claim_memory(entry_bytes * double(items.size()) * double(part.gradients.size()),
               "the table of " + std::to_string(items.size()) + " points at " +
                   std::to_string(part.gradients.size()) + " gradients");
  std::vector<TransferPoint> points;
  std::size_t colors = 0;
  for (const json& item : items) {
    points.push_back(read_point(
        item, "point " + std::to_string(points.size() + 1) + " of the transfer function", part));
    if (item.contains("color")) ++colors;
  }
  if (colors != 0 && colors != points.size())
    fail_at("some points of the transfer function have a color and some have none; give it to all");
  return TransferFunction(std::move(points), colors != 0, std::move(part));
}

TransferFunction read(std::string_view text) {
  json document = parsed_json(text, "a transfer function", ExitCode::input);
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

template <typename Number>
std::string array_text(std::span<const double> numbers) {
  std::vector<std::string> texts;
  for (const double x : numbers) texts.push_back(number_text(static_cast<Number>(x)));
  return "[" + joined(texts, ", ") + "]";
}

/// A float32 number, with just enough digits to give the same float32.
std::string float_text(double number) { return number_text(float(number)); }

}  // namespace

TransferFunction transfer_function_from_json(std::string_view text, std::string_view source) {
  try {
    return read(text);
  } catch (const Error& error) {
    throw Error(error.code(), std::string(source) + ": " + error.what());
  }
}

std::string to_json(const TransferFunction& function) {
  const GradientPart& part = function.gradient_part();
  std::string out = "{";
  if (!part.gradients.empty())
    out += "\"gradients\": " + array_text<float>(part.gradients) + ",\n ";
  std::vector<std::string> rows;
  for (const Isosurface& s : part.isosurfaces)
    rows.push_back("  {\"value\": " + float_text(s.value) +
                   ", \"thickness\": " + number_text(s.thickness) +
                   ", \"attenuation\": " + number_text(s.attenuation) + "}");
  if (!rows.empty()) out += "\"isosurfaces\": [\n" + joined(rows, ",\n") + "\n],\n ";
  rows.clear();
  const std::size_t columns = part.gradients.size();
  for (std::size_t k = 0; k < function.points().size(); ++k) {
    const TransferPoint& p = function.points()[k];
    const std::span row = std::span(part.attenuation).subspan(k * columns, columns);
    rows.push_back("  {\"value\": " + float_text(p.value) + ", \"attenuation\": " +
                   (columns == 0 ? number_text(p.attenuation) : array_text<double>(row)) +
                   (function.has_color() ? ", \"color\": " + array_text<double>(std::array{
                                                                 p.color.r, p.color.g, p.color.b})
                                         : "") +
                   "}");
  }
  return out + "\"points\": [\n" + joined(rows, ",\n") + "\n]}\n";
}

TransferFunction read_transfer_function(const std::filesystem::path& path) {
  const std::string name = path.string();
  return transfer_function_from_json(read_text(name, "transfer function"), name);
}

}  // namespace psivox
