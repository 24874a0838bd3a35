#include "field/field_cursor.h"

#include <algorithm>
#include <glm/common.hpp>

#include "field/index_space.h"

namespace psivox {

FieldCursor::FieldCursor(const Field& field) : index_(std::make_shared<const FieldIndex>(field)) {
  const glm::ivec3 first = field.domain().min & ~15;
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 origin = first + 8 * cube_corner(i);
    known_[std::size_t(i)] = {origin, index_->block(origin)};
  }
}

double FieldCursor::at(const glm::dvec3& point) {
  const glm::ivec3 cell = voxel_below(point), local = cell & 7;
  const glm::dvec3 u = point - glm::dvec3(cell);
  std::array<double, 8> corners;  // z fastest
  if (std::max({local.x, local.y, local.z}) < 7) {
    const LeafValues& values = block(cell & ~7).values;
    const float* first = values.at(local);
    const Strides& s = values.strides;
    for (std::size_t i = 0; i < 8; ++i)
      corners[i] = double(first[(i >> 2) * s.x + (i >> 1 & 1) * s.y + (i & 1) * s.z]);
  } else {
    for (int i = 0; i < 8; ++i)
      corners[std::size_t(i)] = at(cell + glm::ivec3(i >> 2, i >> 1 & 1, i & 1));
  }
  const auto along_z = [&](std::size_t i) { return glm::mix(corners[i], corners[i + 1], u.z); };
  return glm::mix(glm::mix(along_z(0), along_z(2), u.y), glm::mix(along_z(4), along_z(6), u.y),
                  u.x);
}

}  // namespace psivox
