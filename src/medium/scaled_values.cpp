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

ValueScale with_unit(ValueScale scale, const Field& field) {
  if (scale.unit) return scale;
  const glm::dvec2 range = stored_range(field);
  const double size = std::max(-range.x, range.y);
  const bool log = scale.kind == ValueScale::Kind::log;
  scale.unit = log ? least_positive(field) : size * std::pow(10, -symlog_decades);
  if (!(*scale.unit > 0 && *scale.unit < no_value))
    throw Error(ExitCode::input, "--value-scale: grid " + in_quotes(field.name) + " has no value " +
                                     (log ? "above 0" : "but 0"));
  return scale;
}

}  // namespace

std::shared_ptr<const Field> scaled_values(std::shared_ptr<const Field> given,
                                           const ValueScale& wanted) {
  if (wanted.is_linear() || !given->scale.is_linear()) return given;
  const Field& field = *given;
  if (field.half_width > 0)
    throw Error(ExitCode::usage, "--value-scale: level set " + in_quotes(field.name) +
                                     " holds distances; leave it out");
  check_in_memory(field);
  const ValueScale scale = with_unit(wanted, field);
  Field scaled = map_field(field, 1, [&](const glm::vec3& value) {
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
