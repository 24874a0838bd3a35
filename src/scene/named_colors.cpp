#include "scene/color.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <vector>

#include "base/text.h"
#include "psivox/parameters.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

struct Knot {
  double u;
  glm::dvec3 light;
};
using Knots = std::vector<Knot>;

/// From matplotlib's tables by tools/make_colormaps.py, as [place of 256, red, green, blue] in sRGB
/// codes: linear radiance between knots is within half an 8-bit step of them. viridis, inferno,
/// magma, plasma: S. van der Walt and N. Smith (CC0); cividis: J. Nunez, C. Anderton, R. Renslow
/// 2018 (CC0); turbo: A. Mikhailov, Google 2019 (Apache 2.0).
Knots from_table(const std::string& name) {
  static const auto tables = nlohmann::json::parse(color_data().at("colormaps.json"));
  Knots knots;
  for (const std::array<double, 4> k : tables.at(name))
    knots.push_back({k[0] / 255, linear_from_srgb({k[1], k[2], k[3]})});
  return knots;
}

/// A curve of sRGB codes over u, smooth between consecutive `places`, which ascend from 0 to 1.
template <typename Curve>
Knots from_curve(const Curve& curve, std::initializer_list<double> places) {
  Knots knots{{0, linear_from_srgb(curve(0))}};
  for (const double* place = places.begin(); place + 1 != places.end(); ++place)
    for (const double u : color_knots(curve, place[0], place[1]))
      knots.push_back({u, linear_from_srgb(curve(u))});
  return knots;
}

/// Moreland's "cool to warm", ParaView's default.
glm::dvec3 coolwarm(double u) {
  return mix_diverging(glm::dvec3(59, 76, 192) / 255.0, glm::dvec3(180, 4, 38) / 255.0, u);
}

glm::dvec3 gray(double u) { return glm::dvec3(u); }

/// matplotlib's map: red, then green, then blue rise to 1.
constexpr double red_full = 0.365079, green_full = 0.746032;
glm::dvec3 hot(double u) {
  const auto rise = [u](double from, double to) {
    return std::clamp((u - from) / (to - from), 0., 1.);
  };
  return {0.0416 + (1 - 0.0416) * rise(0, red_full), rise(red_full, green_full),
          rise(green_full, 1)};
}

Knots make_knots(Colormap map) {
  if (map == Colormap::coolwarm) return from_curve(coolwarm, {0, 0.5, 1});
  if (map == Colormap::gray) return from_curve(gray, {0, 1});
  if (map == Colormap::labels) return {{0, glm::dvec3(1)}, {1, glm::dvec3(1)}};  // label_color
  if (map == Colormap::hot) return from_curve(hot, {0, red_full, green_full, 1});
  return from_table(enum_names(map)[std::size_t(map)]);
}

const Knots& knots_of(Colormap map) {
  static const std::vector<Knots> all = [] {
    std::vector<Knots> made;
    for (std::size_t i = 0; i < enum_names(Colormap{}).size(); ++i)
      made.push_back(make_knots(static_cast<Colormap>(i)));
    return made;
  }();
  return all[std::size_t(map)];
}

}  // namespace

glm::dvec3 colormap_color(Colormap map, double u) {
  const Knots& knots = knots_of(map);
  const auto above = std::ranges::upper_bound(knots, u, {}, &Knot::u);
  if (above == knots.begin()) return knots.front().light;
  if (above == knots.end()) return knots.back().light;
  const Knot &a = above[-1], &b = *above;
  return glm::mix(a.light, b.light, (u - a.u) / (b.u - a.u));
}

std::vector<double> colormap_knots(Colormap map) {
  std::vector<double> places;
  for (const Knot& k : knots_of(map)) places.push_back(k.u);
  return places;
}

namespace {

/// The colour of RRGGBB or RGB; each of three digits counts twice.
std::optional<glm::dvec3> color_of_digits(std::string_view digits) {
  std::string six(digits);
  if (digits.size() == 3) six = {digits[0], digits[0], digits[1], digits[1], digits[2], digits[2]};
  std::uint32_t codes = 0;
  const auto [end, error] = std::from_chars(six.data(), six.data() + six.size(), codes, 16);
  if (six.size() != 6 || error != std::errc() || end != six.data() + 6) return {};
  return color_of_codes({codes >> 16 & 0xff, codes >> 8 & 0xff, codes & 0xff});
}

}  // namespace

std::optional<glm::dvec3> named_color(std::string_view text) {
  if (text.starts_with('#')) return color_of_digits(text.substr(1));
  // the names of CSS Color Module Level 4, each with #rrggbb
  static const auto css = nlohmann::json::parse(color_data().at("css.json"));
  const auto found = css.find(lower_case(text));
  if (found == css.end()) return {};
  return color_of_digits(found->get<std::string>().substr(1));
}

std::optional<glm::ivec3> color_codes(std::string_view text) {
  const std::vector<std::string> items = split(text);
  glm::ivec3 codes(0);
  if (items.size() != 3) return {};
  for (int c = 0; c < 3; ++c)
    if (!read_number(items[std::size_t(c)], codes[c]) || codes[c] < 0 || codes[c] > 255) return {};
  return std::max({codes.x, codes.y, codes.z}) > 1 ? std::optional(codes) : std::nullopt;
}

glm::dvec3 color_of_codes(const glm::ivec3& codes) {
  return linear_from_srgb(glm::dvec3(codes) / 255.0);
}

std::string hex_text(const glm::ivec3& codes) {
  return formatted("#%02x%02x%02x", unsigned(codes.x), unsigned(codes.y), unsigned(codes.z));
}

bool takes_grey(const Parameter& parameter) { return parameter.metavar == "A|COLOUR"; }

bool is_color(const Parameter& parameter) {
  return parameter.metavar == "COLOUR" || takes_grey(parameter);
}

bool takes_codes(const Parameter& parameter) { return parameter.name == "background"; }

std::string color_notice(const Parameter& parameter, std::string_view text) {
  // light of a few times white is common, one that is meant as codes has a great component
  constexpr int like_codes = 64;
  const bool lights =
      std::holds_alternative<std::vector<DirectionalLight> Scene::*>(parameter.member);
  if (!is_color(parameter) && !lights) return {};
  for (const std::string& item : split(text, ';')) {
    const std::vector<std::string> numbers = split(item);
    if (lights && numbers.size() != 6) continue;
    const std::string direction = lights ? joined(std::span(numbers).first(3)) + "," : "";
    const std::optional<glm::ivec3> codes = color_codes(item.substr(direction.size()));
    if (!codes) continue;
    const std::string written = "--" + parameter.name + " " + item, hex = hex_text(*codes);
    if (takes_codes(parameter))
      return written + " is taken as " + hex +
             ", codes from 0 to 255; a decimal point in a number"
             " makes it linear, where 1 is white";
    if (std::max({codes->x, codes->y, codes->z}) >= like_codes)
      return written + " is linear, where 1 is white; write " + direction + hex +
             " for the codes from 0 to 255";
  }
  return {};
}

}  // namespace psivox
