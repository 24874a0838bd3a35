#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "psivox/field.h"
#include "psivox/leaf_values.h"

namespace psivox {

/// Makes a field of a dense array, which it copies a slab at a time or reads in place. Voxel
/// (0, 0, 0) is the array's first. Blocks of 8^3 voxels that are 0 take no memory, those of another
/// single value are tiles.
class DenseField {
 public:
  /// `channels`: 1 or 3. Throws Error(input) if the shape or the transform is refused.
  DenseField(const std::string& name, const glm::ivec3& shape, int channels,
             const glm::dmat4& world_from_index);

  /// Takes the next 8 planes of x, or what is left of them; z is fastest and channels are
  /// interleaved. It copies the values. Throws Error(memory).
  void add(std::span<const float> slab);

  /// The same for slabs of any strides: the next 8 planes of an axis, which is the same for all
  /// slabs. The slab's first value is that of its smallest voxel.
  void add(const ArrayValues& slab, int axis) { add(slab, axis, false); }

  /// Takes the whole array, in place of slabs, and reads it where it lies. The field and its copies
  /// keep `owner`; until then the values must stay as they are. Only blocks that reach beyond the
  /// array are copied.
  void hold(const ArrayValues& array, std::shared_ptr<const void> owner);

  /// The field, after all values. NaN, Inf and negative values are in it as they were given; a
  /// VdbFile replaces them as those of a file.
  Field finish();

 private:
  struct Block;
  Block summarise(const LeafValues& values, const glm::ivec3& origin) const;
  void copy(const LeafValues& values, const glm::ivec3& origin, float* leaf) const;
  /// Voxels of a block within the array.
  glm::ivec3 size_of_block(const glm::ivec3& origin) const;
  /// Adds the next planes of an axis, whose first voxel is the array's first.
  void add(const ArrayValues& slab, int axis, bool in_place);

  glm::ivec3 shape_;
  int next_plane_ = 0;
  Field field_;
  std::vector<std::shared_ptr<const void>> storage_;
};

}  // namespace psivox
