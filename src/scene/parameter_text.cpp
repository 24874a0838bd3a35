#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <type_traits>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "scene/enum_names.h"
#include "scene/json_problem.h"

namespace psivox {
namespace {

std::string text_of(const std::string& value) { return value; }
std::string text_of(bool value) { return value ? "true" : "false"; }
std::string text_of(int value) { return number_text(value); }
std::string text_of(std::uint64_t value) { return number_text(value); }
std::string text_of(double value) { return number_text(value); }
std::string text_of(const glm::dvec3& v) {
  return text_of(v.x) + "," + text_of(v.y) + "," + text_of(v.z);
}
std::string text_of(const MapRange& r) {
  return text_of(r.ends.x) + (r.percent.x ? "%," : ",") + text_of(r.ends.y) +
         (r.percent.y ? "%" : "");
}
std::string text_of(const OpacityCurve& curve) {
  std::vector<std::string> items;
  for (const glm::dvec2& point : curve.points)
    items.push_back(text_of(point.x) + ":" + text_of(point.y));
  return joined(items);
}
std::string text_of(const DirectionalLight& light) {
  return std::string(light.of_camera ? camera_prefix : "") + text_of(light.direction) + "," +
         text_of(light.color);
}
std::string text_of(const WorldBox& box) { return text_of(box.min) + "," + text_of(box.max); }
std::string text_of(const Plane& plane) {
  return (plane.point ? text_of(*plane.point) + "," : "") + text_of(plane.normal);
}
std::string text_of(const ValueScale& scale) {
  const std::string name = enum_names(scale.kind)[std::size_t(scale.kind)];
  return scale.unit ? name + ":" + text_of(*scale.unit) : name;
}
std::string text_of(const ShownSurface& surface) {
  std::string text = text_of(surface.value);
  if (surface.color)
    text += ":" + hex_text(glm::ivec3(glm::round(255.0 * srgb_from_linear(*surface.color))));
  return surface.opacity == 1 ? text : text + ":" + text_of(surface.opacity);
}
std::string text_of(const glm::ivec2& v) { return text_of(v.x) + "x" + text_of(v.y); }
template <typename E>
requires std::is_enum_v<E> std::string text_of(E value) {
  return enum_names(value)[std::size_t(value)];
}

template <typename T>
std::string text_of(const Parameter& p, const std::vector<T>& items) {
  std::string text;
  for (const T& item : items) text += (text.empty() ? "" : ";") + text_of(item);
  return text.empty() ? p.unset : text;
}

std::string text_of(const Parameter& p, const std::vector<ShownSurface>& surfaces) {
  std::vector<std::string> items;
  for (const ShownSurface& surface : surfaces) items.push_back(text_of(surface));
  return items.empty() ? p.unset : joined(items);
}

std::string text_of(const Parameter& p, const std::optional<std::string>& title) {
  return !title ? p.unset : title->empty() ? "true" : *title;
}

template <typename T>
std::string text_of(const Parameter& p, const T& value) {
  if constexpr (std::is_same_v<T, Background>)
    return value.environment ? std::string(environment_word) : text_of(p, value.color);
  else {
    std::string text = text_of(value);
    if constexpr (std::is_same_v<T, glm::dvec3>)
      if (takes_grey(p) && value == glm::dvec3(value.x)) return text_of(value.x);
    if constexpr (std::is_same_v<T, glm::dvec3>)
      if (takes_codes(p) && color_codes(text)) text.insert(text.find(','), ".0");
    return text;
  }
}

template <typename T>
std::string text_of(const Parameter& p, const std::optional<T>& value) {
  return value ? text_of(p, *value) : p.unset;
}

using nlohmann::json;

// nlohmann-json prints the shortest digits that read back as the same double. What is not UTF-8 is
// a fault of a JSON file's, and replaced.
std::string dumped(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool is_text(const Parameter& p) { return std::holds_alternative<std::string Scene::*>(p.member); }

/// What a JSON value of text or of files must be; empty if it is that, or the parameter neither.
std::string text_problem(const Parameter& p, const json& value) {
  const bool files = std::holds_alternative<std::vector<std::string> Scene::*>(p.member);
  if (value.is_string() || !(files || is_text(p))) return {};
  const auto is_string = [](const json& item) { return item.is_string(); };
  if (files && value.is_array() && std::ranges::all_of(value, is_string)) return {};
  return p.name + ": expected a string" + (files ? " or an array of strings" : "");
}

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
        std::is_same_v<T, std::optional<WorldBox>> || std::is_same_v<T, std::optional<Plane>> ||
        std::is_same_v<T, std::vector<ShownSurface>>;
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
  if (std::holds_alternative<std::optional<std::string> Scene::*>(p.member))
    return text == "true" || text == p.unset ? json(text == "true") : json(text);
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

std::string Range::text() const {
  std::string out;
  const bool lower = std::isfinite(min), upper = std::isfinite(max);
  if (lower && upper && !min_open && !max_open)
    return " from " + number_text(min) + " to " + number_text(max);
  if (lower) out += (min_open ? " above " : " at least ") + number_text(min);
  if (lower && upper) out += " and";
  if (upper) out += (max_open ? " below " : " at most ") + number_text(max);
  return out;
}

bool has_same(const Scene& a, const Scene& b, const Parameter& parameter) {
  return std::visit([&](auto member) { return a.*member == b.*member; }, parameter.member);
}

void copy_parameter(const Scene& from, Scene& to, const Parameter& parameter) {
  std::visit([&](auto member) { to.*member = from.*member; }, parameter.member);
}

bool has_default(const Scene& scene, const Parameter& parameter) {
  static const Scene defaults;
  return has_same(scene, defaults, parameter);
}

void set_default(Scene& scene, const Parameter& parameter) {
  copy_parameter(Scene{}, scene, parameter);
  scene.given.erase(parameter.name);
}

bool is_given(const Scene& scene, const Parameter& parameter) {
  return scene.given.contains(parameter.name) || !has_default(scene, parameter);
}

bool is_given(const Scene& scene, std::string_view name) {
  return is_given(scene, *find_parameter(name));
}

std::string parameter_text(const Scene& scene, const Parameter& parameter) {
  return std::visit([&](auto member) { return text_of(parameter, scene.*member); },
                    parameter.member);
}

std::string parameter_text(const Scene& scene, std::string_view name) {
  return parameter_text(scene, *find_parameter(name));
}

std::string to_json(const Scene& scene) {
  std::string out = "{";
  for (const Parameter& p : parameters()) {
    const std::string value = dumped(json_of(p, utf8_of_bytes(parameter_text(scene, p))));
    out += (out.size() > 1 ? ",\n  \"" : "\n  \"") + p.name + "\": " + value;
  }
  return out + "\n}\n";
}

Scene scene_from_json(std::string_view text, std::string_view source) try {
  const auto fail = [](const std::string& what) { throw Error(ExitCode::usage, what); };
  const json object = parsed_json(text, "a scene", ExitCode::usage);
  if (!object.is_object()) fail("not a scene: expected a JSON object of parameters");
  Scene scene;
  for (const auto& [name, value] : object.items()) {
    const Parameter* p = find_parameter(name);
    if (const std::string problem = p ? text_problem(*p, value) : ""; !problem.empty())
      fail(problem);
    set_parameter(scene, name, p ? bytes_of_utf8(command_line_text(*p, value)) : "");
  }
  // as for the command line
  if (scene.shows(Shows::depth) && !object.contains("exposure")) scene.exposure.reset();
  return scene;
} catch (const Error& error) {
  throw Error(ExitCode::usage, std::string(source) + ": " + error.what());
}

namespace {

constexpr std::size_t most_volumes = 7;  // beside the first

/// NAME of a word NAME=VALUE; empty for other words, which belong to the file's name.
std::string_view name_in(std::string_view word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos) return {};
  const std::string_view name = word.substr(0, equals);
  const bool plain = std::ranges::all_of(name, [](char c) { return c == '-' || std::islower(c); });
  return plain ? name : std::string_view();
}

}  // namespace

Scene scene_of_volume(const Scene& scene, std::string_view text) {
  Scene volume = scene;
  volume.volumes.clear();
  std::vector<std::string> names;  // that it may have for itself
  for (const Parameter& p : parameters()) {
    if (p.of_volume == OfVolume::own || p.of_volume == OfVolume::none) set_default(volume, p);
    if (may_be_of_volume(p)) names.push_back(p.name);
  }
  while (true) {
    const std::size_t space = text.rfind(' ');
    const std::string_view word = text.substr(space + 1);  // npos + 1 is 0
    const std::string_view name = name_in(word);
    if (space == std::string_view::npos || name.empty()) break;
    if (std::ranges::count(names, name) == 0)
      throw Error(ExitCode::usage, "--and " + in_quotes(text) + ": a further volume has no " +
                                       in_quotes(name) + " of its own; it may have " +
                                       joined(names, ", "));
    set_parameter(volume, name, word.substr(name.size() + 1));
    text.remove_suffix(text.size() - space);
  }
  if (text.empty()) throw Error(ExitCode::usage, "--and needs a file");
  volume.input = text;
  return volume;
}

void check_one_volume(const Scene& scene, std::string_view who) {
  if (scene.volumes.empty()) return;
  throw Error(ExitCode::usage, std::string(who) + " is for one volume; leave out --and");
}

void validate_volumes(const Scene& scene) {
  if (scene.volumes.empty()) return;
  const auto fail = [](const std::string& message) { throw Error(ExitCode::usage, message); };
  for (const std::string& volume : scene.volumes) scene_of_volume(scene, volume);
  if (scene.volumes.size() > most_volumes) fail("--and draws at most 7 volumes beside the first");
  if (scene.mode != Mode::alpha) fail("--and is for --mode alpha");
  if (scene.has_function())
    fail(
        "--and: the attenuation of several volumes is their value; leave out --transfer-function, "
        "--colormap, --range and --opacity, or give --look smoke");
  if (scene.resolved_integrator() != Integrator::cell_exact ||
      scene.resolved_sampling() != Sampling::cells || scene.filter != Filter::exact)
    fail("--and draws exact cells; leave out --step, --sampling, --integrator and --filter");
}

}  // namespace psivox
