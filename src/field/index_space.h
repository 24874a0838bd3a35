#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <tuple>
#include <utility>

#include "psivox/field.h"

// Boxes, lines and transforms of index space.

namespace psivox {

/// A box that holds every voxel, and every brick: a grid that reaches 2^30 is refused.
inline constexpr int far_away = 1 << 30;
inline constexpr Box everywhere{glm::ivec3(-far_away), glm::ivec3(far_away)};

/// What two boxes share.
inline Box common(const Box& a, const Box& b) {
  return {glm::max(a.min, b.min), glm::min(a.max, b.max)};
}

/// Points of integer coordinates in a box.
inline std::uint64_t count_of(const Box& box) {
  if (box.empty()) return 0;
  const glm::u64vec3 size(box.max - box.min + 1);
  return size.x * size.y * size.z;
}

/// Calls each(point) for them, z fastest.
template <typename Each>
void for_points(const Box& box, const Each& each) {
  for (int x = box.min.x; x <= box.max.x; ++x)
    for (int y = box.min.y; y <= box.max.y; ++y)
      for (int z = box.min.z; z <= box.max.z; ++z) each(glm::ivec3(x, y, z));
}

/// A corner of the unit cube, by its number from 0 to 7.
inline glm::ivec3 cube_corner(int i) { return {i >> 2, i >> 1 & 1, i & 1}; }

/// A corner of a box, by its number from 0 to 7.
inline glm::ivec3 corner_of(const Box& box, int i) {
  return glm::mix(box.min, box.max, glm::bvec3(cube_corner(i)));
}

/// The least and the greatest coordinates of a box's corners, where place(corner) puts them.
template <typename Place>
std::pair<glm::dvec3, glm::dvec3> bounds_of(const Box& box, const Place& place) {
  glm::dvec3 low(HUGE_VAL), high(-HUGE_VAL);
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 at = place(glm::dvec3(corner_of(box, i)));
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  return {low, high};
}
inline std::pair<glm::dvec3, glm::dvec3> bounds_of(const Box& box, const glm::dmat4& to_from) {
  return bounds_of(
      box, [&](const glm::dvec3& from) { return glm::dvec3(to_from * glm::dvec4(from, 1)); });
}

/// Orders points by x, then y, then z.
inline bool comes_before(const glm::ivec3& a, const glm::ivec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Voxels of a box of bricks. The outermost parts and regions reach farther than there are voxels.
inline Box voxels_of(const Box& bricks) {
  const glm::ivec3 most(far_away / 8);
  return {8 * glm::max(bricks.min, -most), 8 * glm::min(bricks.max, most) + 7};
}

/// The axis of the largest extent; of equal ones the first.
inline int longest_axis(const glm::dvec3& size) {
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

/// The voxels that are nearest to a point and not above it, of 2^29 voxels to either side. Rounding
/// by the library takes longer than all else along a line.
inline glm::ivec3 nearest_voxel(const glm::dvec3& point) {
  constexpr std::int64_t shift = std::int64_t{1} << 30;  // to positive numbers, which are cut off
  const auto nearest = [](double x) {
    return int(std::int64_t(x + (double(shift) + 0.5)) - shift);
  };
  return {nearest(point.x), nearest(point.y), nearest(point.z)};
}

/// Where a line is between two corners of a box: from and to, in lengths of `way`. The first is
/// above the second if it misses the box.
inline glm::dvec2 interval_in(const glm::dvec3& min, const glm::dvec3& max, const glm::dvec3& from,
                              const glm::dvec3& way) {
  glm::dvec2 found(-HUGE_VAL, HUGE_VAL);
  for (int axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0) {
      if (from[axis] < min[axis] || from[axis] > max[axis]) return {HUGE_VAL, -HUGE_VAL};
      continue;
    }
    const double a = (min[axis] - from[axis]) / way[axis], b = (max[axis] - from[axis]) / way[axis];
    found = {std::max(found.x, std::min(a, b)), std::min(found.y, std::max(a, b))};
  }
  return found;
}

/// Whether a transform gives voxels a volume, and numbers with which one can calculate: squares of
/// lengths, volumes and their inverses are finite.
inline bool has_volume(const glm::dmat4& world_from_index) {
  constexpr double most = 1e75;  // the fourth root of the greatest double is 1e77
  const glm::dmat4 inverse = glm::inverse(world_from_index);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (!(std::abs(world_from_index[c][r]) <= most && std::abs(inverse[c][r]) <= most))
        return false;
  return true;
}

/// Length of the shortest column of the transform: the finest voxel [world units]. Steps count in
/// it.
inline double finest_voxel(const Field& field) {
  const glm::dmat4& m = field.world_from_index;
  return std::min({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                   glm::length(glm::dvec3(m[2]))});
}

/// Length of the longest line through a box of so many voxels [world units].
inline double diagonal_of(const Field& field, const glm::dvec3& size) {
  const glm::dmat3 m(field.world_from_index);
  double longest = 0;
  for (const double y : {-1.0, 1.0})
    for (const double z : {-1.0, 1.0})
      longest = std::max(longest, glm::length(m * (size * glm::dvec3(1, y, z))));
  return longest;
}

}  // namespace psivox
