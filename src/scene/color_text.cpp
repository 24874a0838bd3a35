#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "base/text.h"
#include "psivox/parameters.h"
#include "scene/color.h"

namespace psivox {
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
