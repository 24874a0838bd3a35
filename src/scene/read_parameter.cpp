#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"
#include "scene/color.h"
#include "scene/enum_names.h"

namespace psivox {
namespace {

constexpr double greatest_number = std::numeric_limits<float>::max();

// ---- reading: true if the whole text is a value of that type within the range ----

bool read(std::string_view text, const Range&, std::string& value) {
  value = text;
  return true;
}

bool read(std::string_view text, const Range&, bool& value) {
  value = text == "true";
  return value || text == "false";
}

bool read(std::string_view text, const Range& range, int& value) {
  return read_number(text, value) && range.contains(value);
}

bool read(std::string_view text, const Range& range, double& value) {
  return read_number(text, value) && std::abs(value) <= greatest_number && range.contains(value);
}

/// `count` values between `separator`s.
template <typename Vector>
bool read_vector(std::string_view text, char separator, int count, const Range& range,
                 Vector& value) {
  for (int i = 0; i < count; ++i) {
    const std::size_t end = i + 1 < count ? text.find(separator) : text.size();
    if (end == std::string_view::npos || !read(text.substr(0, end), range, value[i])) return false;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return true;
}

bool read(std::string_view text, const Range& range, glm::dvec3& value) {
  return read_vector(text, ',', 3, range, value);
}

bool read(std::string_view text, const Range& range, glm::ivec2& value) {
  return read_vector(text, 'x', 2, range, value);
}

/// A number, or a percentile: 99%, P99%.
bool read_end(std::string_view text, double& value, bool& percent) {
  percent = text.ends_with('%');
  if (percent) text.remove_suffix(1);
  if (percent && text.starts_with('P')) text.remove_prefix(1);
  return read(text, percent ? Range{0, 100} : Range{}, value);
}

bool read(std::string_view text, const Range&, MapRange& value) {
  const std::size_t comma = std::min(text.find(','), text.size());
  return comma < text.size() && read_end(text.substr(0, comma), value.ends.x, value.percent.x) &&
         read_end(text.substr(comma + 1), value.ends.y, value.percent.y);
}

bool read(std::string_view text, const Range&, OpacityCurve& value) {
  for (const std::string& item : split(text)) {
    const std::size_t colon = std::min(item.find(':'), item.size());
    glm::dvec2 point;
    if (colon == item.size() || !read(item.substr(0, colon), Range{0, 1}, point.x) ||
        !read(item.substr(colon + 1), Range{.min = 0}, point.y) ||
        (!value.points.empty() && point.x <= value.points.back().x))
      return false;
    value.points.push_back(point);
  }
  return !value.points.empty();
}

/// log, or symlog:0.1.
bool read(std::string_view text, const Range&, ValueScale& value) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::vector<std::string> names = enum_names(value.kind);
  const auto name = std::ranges::find(names, text.substr(0, colon));
  if (name == names.end()) return false;
  value.kind = ValueScale::Kind(name - names.begin());
  if (colon == text.size()) return true;
  return value.kind == ValueScale::Kind::symlog &&
         read(text.substr(colon + 1), Range{.min = 0, .min_open = true}, value.unit.emplace());
}

/// A value, which a colour and an opacity may follow.
bool read(std::string_view text, ShownSurface& value) {
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() > 3 || !read(parts.front(), Range{}, value.value)) return false;
  if (parts.size() == 1) return true;
  const bool opaque = parts.size() == 2 && read(parts[1], Range{0, 1}, value.opacity);
  if (!opaque && !parts[1].empty()) value.color = named_color(parts[1]);
  return opaque || ((value.color || parts[1].empty()) &&
                    (parts.size() == 2 || read(parts[2], Range{0, 1}, value.opacity)));
}

bool read(std::string_view text, const Range&, std::vector<ShownSurface>& value) {
  return std::ranges::all_of(
      split(text), [&](const std::string& item) { return read(item, value.emplace_back()); });
}

/// Place of the n-th comma, or npos.
std::size_t nth_comma(std::string_view text, int n) {
  std::size_t place = text.find(',');
  while (--n > 0 && place != std::string_view::npos) place = text.find(',', place + 1);
  return place;
}

/// A colour, as is_color() says. The range is that of its numbers.
bool read_color(std::string_view text, const Range& range, glm::dvec3& value) {
  const std::optional<glm::dvec3> named = named_color(text);
  if (named) value = *named;
  return named || read(text, range, value);
}

/// A direction, or a direction and a colour. The range is the colour's.
bool read(std::string_view text, const Range& range, DirectionalLight& value) {
  value.of_camera = text.starts_with(camera_prefix);
  if (value.of_camera) text.remove_prefix(camera_prefix.size());
  const std::size_t color = nth_comma(text, 3);
  if (color == std::string_view::npos) return read(text, Range{}, value.direction);
  return read(text.substr(0, color), Range{}, value.direction) &&
         read_color(text.substr(color + 1), range, value.color);
}

/// Items with a semicolon between them.
template <typename T>
bool read(std::string_view text, const Range& range, std::vector<T>& value) {
  for (const std::string& item : split(text, ';'))
    if (!read(item, range, value.emplace_back())) return false;
  return !value.empty();
}

bool read(std::string_view text, const Range&, WorldBox& value) {
  const std::size_t third = nth_comma(text, 3);
  return third != std::string_view::npos && read(text.substr(0, third), Range{}, value.min) &&
         read(text.substr(third + 1), Range{}, value.max);
}

/// An axis (z, -z), an axis and a place (z=3), a normal, or a point and a normal.
bool read(std::string_view text, const Range&, Plane& value) {
  const bool backwards = text.starts_with('-');
  const std::string_view axis = text.substr(backwards ? 1 : 0);
  const std::size_t index =
      axis.empty() ? std::string_view::npos : std::string_view("xyz").find(axis[0]);
  if (index == std::string_view::npos) {
    const std::size_t third = nth_comma(text, 3);
    if (third == std::string_view::npos) return read(text, Range{}, value.normal);
    value.point.emplace();
    return read(text.substr(0, third), Range{}, *value.point) &&
           read(text.substr(third + 1), Range{}, value.normal);
  }
  value.normal = glm::dvec3(0);
  value.normal[int(index)] = backwards ? -1 : 1;
  if (axis.size() == 1) return true;
  value.point = glm::dvec3(0);
  return axis[1] == '=' && read(axis.substr(2), Range{}, (*value.point)[int(index)]);
}

/// Bytes, with the suffixes of GNU's tools: K = KiB = 1024, KB = 1000, and so on.
bool read(std::string_view text, const Range&, std::uint64_t& value) {
  if (read_number(text, value)) return true;
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  double number = 0;
  if (!read_number(text.substr(0, digits), number)) return false;
  const std::string_view suffix = text.substr(digits);
  double factor = 1, decimal_factor = 1;
  if (!suffix.empty() && suffix != "B") {
    const std::size_t power = std::string_view("KMGT").find(suffix[0]);
    if (power == std::string_view::npos) return false;
    factor = std::pow(1024.0, double(power + 1));
    decimal_factor = std::pow(1000.0, double(power + 1));
    const std::string_view rest = suffix.substr(1);
    if (rest == "B")
      factor = decimal_factor;
    else if (!rest.empty() && rest != "iB")
      return false;
  }
  const double bytes = std::floor(number * factor);
  if (!(bytes < 0x1p64)) return false;
  value = std::uint64_t(bytes);
  return true;
}

template <typename E>
requires std::is_enum_v<E>
bool read(std::string_view text, const Range&, E& value) {
  const std::vector<std::string> names = enum_names(E{});
  const auto found = std::find(names.begin(), names.end(), text);
  if (found == names.end()) return false;
  value = static_cast<E>(found - names.begin());
  return true;
}

// ---- the text of what is expected ----

std::string kind_text(const Parameter&, const std::string&) { return "text"; }
std::string kind_text(const Parameter&, const std::vector<std::string>&) {
  return "files, with ; between them";
}
std::string kind_text(const Parameter&, bool) { return "true or false"; }
std::string kind_text(const Parameter& p, int) { return "a whole number" + p.range.text(); }
std::string kind_text(const Parameter&, std::uint64_t) { return "a size such as 512M or 1.5GiB"; }
std::string kind_text(const Parameter& p, double) { return "a number" + p.range.text(); }
std::string kind_text(const Parameter& p, const glm::dvec3&) {
  const std::string range = p.range.text();
  if (takes_grey(p)) return "a number, #rrggbb, a name of CSS, or R,G,B, each" + range;
  if (is_color(p)) return "#rrggbb, a name of CSS, or three linear numbers R,G,B, each" + range;
  return "three numbers " + p.metavar + (range.empty() ? "" : ", each" + range);
}
std::string kind_text(const Parameter& p, const Background& kind) {
  return kind_text(p, kind.color) + ", or " + std::string(environment_word);
}
std::string kind_text(const Parameter& p, const MapRange&) {
  return "two numbers " + p.metavar + " or percentiles such as 1%,99%";
}
std::string kind_text(const Parameter&, const ValueScale&) {
  return "linear, log, symlog, or symlog:T with T above 0";
}
std::string kind_text(const Parameter&, const std::vector<ShownSurface>&) {
  return "numbers, each perhaps with a colour (#rrggbb or a name of CSS) and an opacity from 0 to "
         "1, "
         "such as 0.2:#ff8800:0.3,0.5";
}
std::string kind_text(const Parameter&, const OpacityCurve&) {
  return "places from 0 to 1, ascending, each with a factor that is at least 0, such as "
         "0:0,0.3:0.1,1:1";
}
std::string kind_text(const Parameter& p, const std::vector<DirectionalLight>&) {
  return p.metavar + ", colours as #rrggbb, names of CSS, or R,G,B" + p.range.text();
}
std::string kind_text(const Parameter&, const WorldBox&) { return "six numbers X0,Y0,Z0,X1,Y1,Z1"; }
std::string kind_text(const Parameter&, const Plane&) {
  return "an axis and a place such as z=3, a normal X,Y,Z, or a point and a normal, X,Y,Z,NX,NY,NZ";
}
std::string kind_text(const Parameter& p, const glm::ivec2&) {
  return p.metavar + " in whole numbers, each" + p.range.text();
}
template <typename E>
requires std::is_enum_v<E> std::string kind_text(const Parameter&, E) {
  return joined(enum_names(E{}), " or ");
}

template <typename T>
std::string near_text(std::string_view text, const T&) {
  if constexpr (std::is_enum_v<T>) return suggestion(text, enum_names(T{}));
  return "";
}

/// Says so if the text has a number that float32 does not hold.
std::string size_text(std::string_view text) {
  constexpr const char* separators = ",;:=x%";
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    double number = 0;
    if (read_number(text.substr(begin, end - begin), number) && std::abs(number) > greatest_number)
      return "; numbers go up to 3.4e38";
    begin = end + 1;
  }
  return "";
}

template <typename T>
[[noreturn]] void refuse(const Parameter& p, std::string_view text, const T& kind) {
  const std::string unset = p.unset.empty() ? "" : p.unset + " or ";
  const std::string unit = p.unit.empty() ? "" : " [" + p.unit + "]";
  throw Error(ExitCode::usage, (p.positional ? "" : "--") + p.name + " " + in_quotes(text) +
                                   ": expected " + unset + kind_text(p, kind) + unit +
                                   near_text(text, kind) + size_text(text));
}

template <typename T>
bool read(const Parameter& p, std::string_view text, T& value) {
  if constexpr (std::is_same_v<T, Background>) {
    value.environment = text == environment_word;
    return value.environment || read(p, text, value.color);
  } else {
    if constexpr (std::is_same_v<T, glm::dvec3>) {
      if (double grey = 0; takes_grey(p) && read(text, p.range, grey)) {
        value = glm::dvec3(grey);
        return true;
      }
      const auto codes = takes_codes(p) ? color_codes(text) : std::nullopt;
      if (codes) value = color_of_codes(*codes);
      if (is_color(p)) return codes || read_color(text, p.range, value);
    }
    return read(text, p.range, value);
  }
}

template <typename T>
void assign(const Parameter& p, std::string_view text, T& target) {
  T value{};
  if (!read(p, text, value)) refuse(p, text, value);
  target = value;
}

/// A name or a file; `none` is none where that is the default.
void assign(const Parameter& p, std::string_view text, std::string& target) {
  std::string value;
  if (!read(p, text, value)) refuse(p, text, value);
  target = text == "none" && p.default_text == "none" ? "" : value;
}

/// A text that may be left out: true is an empty one.
void assign(const Parameter& p, std::string_view text, std::optional<std::string>& target) {
  target.reset();
  if (text != p.unset) target = text == "true" ? "" : text;
}

template <typename T>
void assign(const Parameter& p, std::string_view text, std::optional<T>& target) {
  if (text == p.unset) {
    target.reset();
    return;
  }
  T value{};
  assign(p, text, value);
  target = value;
}

template <typename T>
void assign(const Parameter& p, std::string_view text, std::vector<T>& target) {
  std::vector<T> items;
  if (text != p.unset && !read(text, p.range, items)) refuse(p, text, items);
  target = std::move(items);
}

}  // namespace

bool Range::contains(double value) const {
  const bool above = min_open ? value > min : value >= min;
  const bool below = max_open ? value < max : value <= max;
  return above && below;
}

void set_parameter(Scene& scene, std::string_view name, std::string_view text) {
  const Parameter* p = find_parameter(name);
  if (!p)
    throw Error(ExitCode::usage, "unknown parameter " + in_quotes(name) +
                                     suggestion(name, names_in(parameters(), &Parameter::name)));
  std::visit([&](auto member) { assign(*p, text, scene.*member); }, p->member);
  scene.given.insert(p->name);
}

}  // namespace psivox
