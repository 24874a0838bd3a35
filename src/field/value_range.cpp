#include "field/value_range.h"

#include <algorithm>
#include <cmath>

#include "field/lane_range.h"
#include "field/leaf_values.h"

namespace psivox {
namespace {

void include(glm::dvec2& range, float value) {
  range.x = std::min(range.x, double(value));
  range.y = std::max(range.y, double(value));
}

/// Of all values of all channels, and 0.
glm::dvec2 whole_range(const Field& field) {
  glm::dvec2 range = fold_leaves(
      field, glm::dvec2(0),
      [](glm::dvec2& found, const Leaf&, const OrderedValues& values) {
        constexpr std::size_t lanes = 64;
        LaneRange<lanes> of_leaf;
        for (std::size_t i = 0; i < values.size(); i += lanes) of_leaf.include(values.data() + i);
        include(found, of_leaf.least());
        include(found, of_leaf.greatest());
      },
      [](const glm::dvec2& a, const glm::dvec2& b) {
        return glm::dvec2(std::min(a.x, b.x), std::max(a.y, b.y));
      });
  for (const Tile& tile : field.tiles)
    for (int c = 0; c < field.channels; ++c) include(range, tile.value[c]);
  return range;
}

}  // namespace

glm::dvec2 stored_range(const Field& field) {
  return field.stored_range ? glm::dvec2(*field.stored_range) : whole_range(field);
}

glm::dvec2 range_of_all(const Field& field) {
  return field.channels == 1 ? stored_range(field) : whole_range(field);
}

glm::dvec2 active_range(const Field& field) {
  if (field.active_range) return glm::dvec2(*field.active_range);
  glm::dvec2 range(HUGE_VAL, -HUGE_VAL);
  for_active(field, [&](float value, std::uint64_t) { include(range, value); });
  return range.x <= range.y ? range : glm::dvec2(0);
}

double active_percentile(const Field& field, double percent) {
  const auto known = field.active_percentiles.find(percent);
  if (known != field.active_percentiles.end()) return known->second;
  check_in_memory(field);
  return value_percentile([&](const auto& take) { for_active(field, take); }, percent);
}

}  // namespace psivox
