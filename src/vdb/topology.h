#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <type_traits>
#include <vector>

#include "field/index_space.h"
#include "psivox/field.h"
#include "survey.h"

// What is read of a grid: its topology, and then its leaves.

namespace psivox::vdb {

/// Facts about a tree for the checks and the info rows.
struct GridSummary {
  int channels = 0;
  std::uint64_t active_voxels = 0;  ///< active tiles count with all their voxels
  std::uint64_t leaves = 0;
  std::uint64_t active_tiles = 0;
  Box active_box;
  glm::dvec3 background{0};  ///< a scalar's in every component
};

/// A value in a tree's node that fills a cube of voxels. As double it keeps the grid's own type.
struct TilePart {
  glm::ivec3 origin;
  int width;
  glm::dvec3 value;
  bool active;

  Tile tile() const { return {origin, width, glm::vec3(value)}; }
};

/// A grid's tree without values of leaves.
struct Topology {
  std::vector<glm::ivec3> leaves;  ///< their origins, in the tree's order
  std::vector<LeafMask> masks;     ///< of each leaf
  /// Tiles of the root first, then those 128 voxels wide, then those 8 voxels wide, without
  /// inactive tiles of the background's value.
  std::vector<TilePart> tiles;
  GridSummary summary;
};

/// A leaf of a grid of any type.
class DecodedLeaf {
 public:
  explicit DecodedLeaf(const LeafMask& mask) : mask_(mask) {}

  const LeafMask& active() const { return mask_; }
  /// Copies 512 * channels values, vectors interleaved.
  virtual void copy_to(float* values) const = 0;
  virtual void copy_to(double* values) const = 0;

 protected:
  ~DecodedLeaf() = default;

 private:
  const LeafMask& mask_;
};

/// What becomes of a leaf, by its number. Several threads call it.
using TakeLeaf = std::function<void(std::size_t n, const DecodedLeaf& leaf)>;

/// A leaf whose values copy(values) writes, to floats or to doubles.
template <typename Copy>
class MadeLeaf final : public DecodedLeaf {
 public:
  MadeLeaf(const LeafMask& mask, const Copy& copy) : DecodedLeaf(mask), copy_(copy) {}
  void copy_to(float* values) const override { copy_(values); }
  void copy_to(double* values) const override { copy_(values); }

 private:
  Copy copy_;
};

/// Such a function, by the value of each voxel of a scalar grid.
template <typename ValueOf>
auto each_voxel(const ValueOf& value_of) {
  return [value_of](auto* values) {
    for (std::size_t i = 0; i < kLeafVoxels; ++i)
      values[i] = static_cast<std::decay_t<decltype(*values)>>(value_of(i));
  };
}

}  // namespace psivox::vdb
