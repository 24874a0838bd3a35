#include "check_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/matrix.hpp>
#include <optional>
#include <stdexcept>
#include <vector>

#include "grid_check.h"
#include "psivox/leaf_values.h"
#include "sanitise.h"

namespace psivox::vdb {
namespace {

constexpr const char* bad_values = "values are not finite, or negative";

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

bool is_finite(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(m[column][row])) return false;
  return true;
}

/// A cube of leaves of one width, in a list in the tree's order.
struct Cube {
  TreeOrder order;
  glm::ivec3 origin;
};

void check_order(const std::vector<Cube>& cubes, int width) {
  for (const Cube& cube : cubes)
    for (int axis = 0; axis < 3; ++axis)
      require(cube.origin[axis] % width == 0, "a block lies between the places of blocks");
  for (std::size_t n = 1; n < cubes.size(); ++n)
    require(cubes[n - 1].order < cubes[n].order, "blocks are not in order");
}

/// No small cube may lie in a wide one. All that lie in it would follow its origin.
void check_apart(const std::vector<Cube>& wide, int width, const std::vector<Cube>& small) {
  for (const Cube& cube : wide) {
    const auto first = std::ranges::lower_bound(small, cube.order, std::less{}, &Cube::order);
    const bool inside = first != small.end() && (first->origin & ~(width - 1)) == cube.origin;
    require(!inside, "blocks overlap");
  }
}

void check_places(const Field& field) {
  constexpr std::array<int, 4> widths{8, 8, 128, 4096};  // of leaves, then of tiles
  std::array<std::vector<Cube>, 4> cubes;
  cubes[0].reserve(field.leaves.size());
  for (const Leaf& leaf : field.leaves) cubes[0].push_back({tree_order(leaf.origin), leaf.origin});
  for (const Tile& tile : field.tiles) {
    const auto width = std::find(widths.begin() + 1, widths.end(), tile.width);
    require(width != widths.end(), "a tile has an impossible width");
    cubes[static_cast<std::size_t>(width - widths.begin())].push_back(
        {tree_order(tile.origin), tile.origin});
  }
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    check_order(cubes[i], widths[i]);
    for (std::size_t smaller = 0; smaller < i; ++smaller)
      check_apart(cubes[i], widths[i], cubes[smaller]);
  }
}

void check_range(const std::optional<glm::vec2>& range) {
  require(!range || !(std::isnan(range->x) || std::isnan(range->y)), "an impossible range");
}

void check_values(const Field& field, GridRole role, bool stored) {
  for (const Tile& tile : field.tiles)
    require(all_good({&tile.value.x, static_cast<std::size_t>(field.channels)}, role,
                     /*infinite=*/field.survey.has_value()),
            bad_values);
  if (stored) return;
  std::atomic<bool> good = true;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, field.leaves.size(), 64), [&](const auto& range) {
        for (std::size_t n = range.begin(); n != range.end(); ++n)
          if (!all_good(
                  {field.leaves[n].values, kLeafVoxels * static_cast<std::size_t>(field.channels)},
                  role))
            good = false;
      });
  require(good, bad_values);
}

}  // namespace

bool is_possible(const ValueSurvey& survey) {
  if (!std::isfinite(survey.largest) || survey.largest < 0) return false;
  for (const Extent& extent : {survey.all, survey.active, survey.in_box})
    if (std::isnan(extent.min) || std::isnan(extent.max)) return false;
  return true;
}

void check_field(const FieldFacts& facts, GridRole role) {
  const Field& field = facts.field;
  require(field.channels == 1 || field.channels == 3, "an impossible number of channels");
  require(!field.active_box.empty() && !too_large(field.active_box), "an impossible box");
  require(is_finite(field.world_from_index) && glm::determinant(field.world_from_index) != 0,
          "an impossible transform");
  require(std::isfinite(field.half_width) && field.half_width >= 0, "an impossible half width");
  require(std::isfinite(field.replaced.least), "an impossible least value");
  check_range(field.active_range);
  check_range(field.stored_range);
  require(!field.survey || (facts.stored && is_possible(*field.survey)), "an impossible survey");
  require(!facts.stored || field.survey || (field.active_range && field.stored_range), "no ranges");
  for (const auto& [percent, value] : field.active_percentiles)
    require(std::isfinite(percent) && !std::isnan(value), "an impossible percentile");
  check_places(field);
  check_values(field, role, facts.stored);
}

}  // namespace psivox::vdb
