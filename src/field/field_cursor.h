#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>

#include "field/field_index.h"
#include "field/index_space.h"

namespace psivox {

/// Reads a field's first channel at places that are near each other. It keeps the blocks that it
/// read last: each thread needs a copy, which shares the rest.
class FieldCursor {
 public:
  explicit FieldCursor(const Field& field) : index_(std::make_shared<const FieldIndex>(field)) {}

  /// Value of a voxel.
  double at(const glm::ivec3& voxel) {
    const glm::ivec3 origin = voxel & ~7;
    return double(*block(origin).values.at(voxel - origin));
  }

  /// FieldIndex's, which is not asked where a block is stored.
  std::size_t empty_steps(const glm::dvec3& point, const glm::dvec3& step) {
    return block(nearest_voxel(point) & ~7).stored ? 0 : index_->empty_steps(point, step);
  }

 private:
  const FieldIndex::Block& block(const glm::ivec3& origin) {
    const glm::ivec3 odd = (origin >> 3) & 1;
    Known& known = known_[std::size_t(4 * odd.x + 2 * odd.y + odd.z)];
    if (known.origin != origin) known = {origin, index_->block(origin)};
    return known.block;
  }

  std::shared_ptr<const FieldIndex> index_;
  /// Blocks around a corner: each has a place of its own, by the parity of its number on each axis.
  struct Known {
    glm::ivec3 origin{1};  ///< of none
    FieldIndex::Block block{};
  };
  std::array<Known, 8> known_;
};

}  // namespace psivox
