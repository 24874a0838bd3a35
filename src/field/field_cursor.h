#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>

#include "field/field_index.h"

namespace psivox {

/// The voxel that is nearest to a point, of 2^29 voxels to either side. Rounding by the library
/// takes longer than all else along a line.
inline glm::ivec3 nearest_voxel(const glm::dvec3& point) {
  constexpr std::int64_t shift = std::int64_t{1} << 30;  // to positive numbers, which are cut off
  const auto nearest = [](double x) {
    return int(std::int64_t(x + (double(shift) + 0.5)) - shift);
  };
  return {nearest(point.x), nearest(point.y), nearest(point.z)};
}

/// Reads a field's first channel at places that are near each other. It keeps the blocks that it
/// read last: each thread needs a copy, which shares the rest.
class FieldCursor {
 public:
  explicit FieldCursor(const Field& field);

  const FieldIndex& index() const { return *index_; }
  /// Value of a voxel, and between voxels.
  double at(const glm::ivec3& voxel);
  double at(const glm::dvec3& point);

 private:
  const FieldIndex::Block& block(const glm::ivec3& origin);

  std::shared_ptr<const FieldIndex> index_;
  /// Blocks around a corner: each has a place of its own, by the parity of its number on each axis.
  struct Known {
    glm::ivec3 origin;
    FieldIndex::Block block;
  };
  std::array<Known, 8> known_;
};

}  // namespace psivox
