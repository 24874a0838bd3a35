#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "psivox/field.h"

namespace psivox {

/// Makes a field of a dense array, a slab at a time. Voxel (0, 0, 0) is the array's first. Blocks
/// of 8^3 voxels that are 0 take no memory, those of another single value are tiles.
class DenseField {
 public:
  /// `channels`: 1, or 3 interleaved. Throws Error(input) if the shape or the transform is refused.
  DenseField(const std::string& name, const glm::ivec3& shape, int channels,
             const glm::dmat4& world_from_index);

  /// Takes the next 8 planes of x, or what is left of them; z is fastest. It copies the values.
  /// Throws Error(memory).
  void add(std::span<const float> slab);

  /// The field, after the last slab. NaN, Inf and negative values are in it as they were given; a
  /// VdbFile replaces them as those of a file.
  Field finish();

 private:
  struct Block;
  Block summarise(std::span<const float> slab, int planes, int y, int z) const;
  void copy(std::span<const float> slab, int planes, int y, int z, float* leaf) const;

  glm::ivec3 shape_;
  int next_plane_ = 0;
  Field field_;
  std::vector<std::shared_ptr<const float[]>> storage_;
};

}  // namespace psivox
