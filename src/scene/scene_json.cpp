#include <algorithm>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

using nlohmann::json;

// nlohmann-json prints the shortest digits that read back as the same double. A file name need not
// be UTF-8, which JSON must.
std::string dumped(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool is_text(const Parameter& p) { return std::holds_alternative<std::string Scene::*>(p.member); }

/// The separator of a vector's text; 0 for a parameter that is not a vector.
char separator(const Parameter& p) {
  const auto of_type = []<typename T>(T Scene::*) {
    if (std::is_same_v<T, glm::ivec2>) return 'x';
    if (std::is_same_v<T, std::vector<std::string>>) return ';';
    const bool list =
        std::is_same_v<T, glm::dvec3> || std::is_same_v<T, std::optional<glm::dvec3>> ||
        std::is_same_v<T, std::optional<Background>> ||
        std::is_same_v<T, std::optional<MapRange>> ||
        std::is_same_v<T, std::vector<DirectionalLight>> ||
        std::is_same_v<T, std::optional<WorldBox>> || std::is_same_v<T, std::optional<Plane>>;
    return list ? ',' : '\0';
  };
  return std::visit(of_type, p.member);
}

bool is_plane(const Parameter& p) {
  return std::holds_alternative<std::optional<Plane> Scene::*>(p.member);
}

/// One item of a parameter's text: numbers and lists of them as such, all else as a text.
json item_json(const Parameter& p, std::string_view text) {
  if (text.starts_with(camera_prefix))
    return {{"camera", item_json(p, text.substr(camera_prefix.size()))}};
  const bool whole = separator(p) == 'x' || std::holds_alternative<int Scene::*>(p.member) ||
                     std::holds_alternative<std::uint64_t Scene::*>(p.member);
  if (text == "true" || text == "false") return text == "true";
  json items = json::array();
  for (const std::string& item : split(text, separator(p) == 'x' ? 'x' : ',')) {
    double number = 0;
    if (!read_number(item, number) || is_plane(p)) return text;
    items.push_back(whole ? json::parse(item) : json(number));
  }
  return items.size() == 1 ? items.front() : items;
}

/// A parameter's text as JSON. One light of the world is its six numbers; several are an array.
json json_of(const Parameter& p, const std::string& text) {
  if (is_text(p) || text == p.unset) return text;
  const bool files = separator(p) == ';';
  if (!files && !std::holds_alternative<std::vector<DirectionalLight> Scene::*>(p.member))
    return item_json(p, text);
  json items = json::array();
  for (const std::string& item : split(text, ';'))
    items.push_back(files ? json(item) : item_json(p, item));
  return items.size() == 1 && items.front().is_array() ? items.front() : items;
}

/// A JSON value in the command line's syntax, so that the same code reads both. A value without
/// such a form stays JSON, and set_parameter refuses it with its own message.
std::string command_line_text(const Parameter& p, const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_object() && value.size() == 1 && value.contains("camera"))
    return "camera:" + command_line_text(p, value["camera"]);
  if (!value.is_array() || !separator(p)) return dumped(value);
  const bool list = !value.empty() && value.front().is_structured();
  std::string text;
  for (const json& item : value) {
    if (!text.empty()) text += list ? ';' : separator(p);
    if (list || (item.is_string() && separator(p) == ';'))
      text += command_line_text(p, item);
    else
      text += dumped(is_color(p) && item.is_number() ? json(item.get<double>()) : item);
  }
  return text;
}

}  // namespace

std::string to_json(const Scene& scene) {
  std::string out = "{";
  for (const Parameter& p : parameters()) {
    const std::string value = dumped(json_of(p, parameter_text(scene, p)));
    out += (out.size() > 1 ? ",\n  \"" : "\n  \"") + p.name + "\": " + value;
  }
  return out + "\n}\n";
}

Scene scene_from_json(std::string_view text, std::string_view source) {
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::usage, std::string(source) + ": " + what);
  };
  json object;
  try {
    object = json::parse(text);
  } catch (const json::parse_error& error) {
    const std::string_view before = text.substr(0, error.byte);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    fail("not a scene in JSON: line " + std::to_string(line) + " is not valid");
  } catch (const json::out_of_range&) {
    fail("not a scene in JSON: a number is beyond double precision");
  }
  if (!object.is_object()) fail("not a scene: expected a JSON object of parameters");
  Scene scene;
  for (const auto& [name, value] : object.items()) {
    const Parameter* p = find_parameter(name);
    if (p && is_text(*p) && !value.is_string()) fail(name + ": expected a string");
    try {
      set_parameter(scene, name, p ? command_line_text(*p, value) : "");
    } catch (const Error& error) {
      fail(error.what());
    }
  }
  // as for the command line
  if (scene.shows(Shows::depth) && !object.contains("exposure")) scene.exposure.reset();
  return scene;
}

}  // namespace psivox
