#include <cmath>

#include "base/text.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "scene/enum_names.h"

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

}  // namespace psivox
