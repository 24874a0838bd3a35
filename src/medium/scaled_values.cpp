#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "field/leaf_values.h"
#include "field/value_range.h"
#include "medium/map_field.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr double no_value = std::numeric_limits<double>::infinity();

/// Decades of symlog beside 0, if it is not said.
constexpr double symlog_decades = 3;

double least_positive(const Field& field) {
  const auto take = [](double& found, double value) {
    if (value > 0) found = std::min(found, value);
  };
  double found = fold_leaves(
      field, no_value,
      [&](double& own, const Leaf&, const OrderedValues& values) {
        for (const float value : values) take(own, double(value));
      },
      [](double a, double b) { return std::min(a, b); });
  for (const Tile& tile : field.tiles) take(found, double(tile.value.x));
  return found;
}

ValueScale with_unit(ValueScale scale, const Field& field, Team& team) {
  if (scale.unit) return scale;
  const glm::dvec2 range = stored_range(field);
  const double size = std::max(-range.x, range.y);
  const bool log = scale.kind == ValueScale::Kind::log;
  if (!log)
    scale.unit = size * std::pow(10, -symlog_decades);
  else if (field.reader)  // a member alone reads them all
    scale.unit = team.gather(team.first() ? least_positive(field) : 0.0).front();
  else
    scale.unit = least_positive(field);
  if (!(*scale.unit > 0 && *scale.unit < no_value))
    throw Error(ExitCode::input, "--value-scale: grid " + in_quotes(field.name) + " has no value " +
                                     (log ? "above 0" : "but 0"));
  return scale;
}

/// The field whose leaves' values pass through a scale whenever they are read.
Field scaled_in_file(const Field& field, const ValueScale& scale) {
  Field scaled = field;
  for (Tile& tile : scaled.tiles) tile.value.x = float(scale.scaled(double(tile.value.x)));
  scaled.reader = [read = field.reader, scale](
                      const FieldHead& head, std::span<const std::uint32_t> leaves, float* values) {
    read(head, leaves, values);
    for (float& value : std::span(values, 512 * leaves.size()))
      value = float(scale.scaled(double(value)));
  };
  return scaled;
}

}  // namespace

std::shared_ptr<const Field> scaled_values(std::shared_ptr<const Field> given,
                                           const ValueScale& wanted, Team& team) {
  if (wanted.is_linear() || !given->scale.is_linear()) return given;
  const Field& field = *given;
  if (field.half_width > 0)
    throw Error(ExitCode::usage, "--value-scale: level set " + in_quotes(field.name) +
                                     " holds distances; leave it out");
  const ValueScale scale = with_unit(wanted, field, team);
  Field scaled = field.reader ? scaled_in_file(field, scale)
                              : map_field(field, 1, [&](const glm::vec3& value) {
                                  return glm::vec3(float(scale.scaled(double(value.x))), 0, 0);
                                });
  scaled.scale = scale;
  const auto of_range = [&](const glm::dvec2& range) {
    return glm::vec2(scale.scaled(range.x), scale.scaled(range.y));
  };
  scaled.stored_range = of_range(stored_range(field));
  scaled.active_range = of_range(active_range(field));
  for (auto& [percent, value] : scaled.active_percentiles) value = scale.scaled(value);
  return std::make_shared<const Field>(std::move(scaled));
}

}  // namespace psivox
