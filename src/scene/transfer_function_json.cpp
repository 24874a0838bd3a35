#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "psivox/error.h"
#include "psivox/parameters.h"
#include "psivox/transfer_function.h"
#include "scene/number_text.h"
#include "scene/paraview_map.h"

namespace psivox {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::string& what) { throw Error(ExitCode::input, what); }

void check_keys(const json& object, const std::vector<std::string>& known,
                const std::string& where) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string nearest = nearest_name(key, known);
    fail(where + ": unknown key " + in_quotes(key) +
         (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }
}

double number(const json& value, const std::string& where) {
  if (!value.is_number()) fail(where + ": expected a number");
  return value.get<double>();
}

TransferPoint read_point(const json& object, const std::string& where) {
  if (!object.is_object()) fail(where + ": expected an object of value, attenuation and color");
  check_keys(object, {"value", "attenuation", "color"}, where);
  for (const char* key : {"value", "attenuation"}) {
    if (!object.contains(key)) fail(where + ": has no " + key);
  }
  TransferPoint point;
  point.value = number(object["value"], where + ": value");
  point.attenuation = number(object["attenuation"], where + ": attenuation");
  if (!object.contains("color")) return point;
  const json& color = object["color"];
  if (!color.is_array() || color.size() != 3) fail(where + ": color: expected [r, g, b]");
  for (std::size_t c = 0; c < 3; ++c)
    point.color[static_cast<int>(c)] = number(color[c], where + ": color");
  return point;
}

TransferFunction read_points(const json& object) {
  check_keys(object, {"points"}, "the transfer function");
  if (!object.contains("points")) fail("the transfer function has no points");
  const json& list = object["points"];
  if (!list.is_array()) fail("points: expected an array");
  std::vector<TransferPoint> points;
  std::size_t colors = 0;
  for (const json& item : list) {
    points.push_back(read_point(
        item, "point " + std::to_string(points.size() + 1) + " of the transfer function"));
    if (item.contains("color")) ++colors;
  }
  if (colors != 0 && colors != points.size())
    fail("some points of the transfer function have a color and some have none; give it to all");
  return TransferFunction(std::move(points), colors != 0);
}

TransferFunction read(std::string_view text) {
  json document;
  try {
    document = json::parse(text);
  } catch (const json::exception& error) {
    fail("not a transfer function in JSON: " + std::string(error.what()));
  }
  if (document.is_array()) {
    if (document.size() != 1)
      fail("holds " + std::to_string(document.size()) + " colour maps; export one alone");
    document = json(document[0]);
  }
  if (!document.is_object()) fail("not a transfer function: expected a JSON object of points");
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

std::string to_json(const TransferFunction& function) {
  std::string out;
  for (const TransferPoint& p : function.points()) {
    out += out.empty() ? "{\"points\": [\n" : ",\n";
    out += "  {\"value\": " + number_text(static_cast<float>(p.value)) +
           ", \"attenuation\": " + number_text(p.attenuation);
    if (function.has_color())
      out += ", \"color\": [" + number_text(p.color.r) + ", " + number_text(p.color.g) + ", " +
             number_text(p.color.b) + "]";
    out += "}";
  }
  return out + "\n]}\n";
}

TransferFunction read_transfer_function(const std::filesystem::path& path) {
  const auto cannot_read = [&](const char* why) {
    fail("cannot read transfer function " + in_quotes(path.string()) + ": " + why);
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) cannot_read(std::strerror(EISDIR));
  std::ifstream in(path, std::ios::binary);
  if (!in) cannot_read(std::strerror(errno));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) cannot_read(std::strerror(errno));
  return transfer_function_from_json(text, path.string());
}

}  // namespace psivox
