#pragma once

#include <openvdb/openvdb.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <istream>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "grid_types.h"
#include "psivox/field.h"
#include "survey.h"

// What is read of a grid: its topology, and then its leaves.

namespace psivox::vdb {

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
  std::vector<glm::ivec3> leaves;     ///< their origins, in the tree's order
  std::vector<std::uint16_t> active;  ///< voxels of each leaf
  std::vector<LeafMask> masks;        ///< of each leaf, if wanted
  /// Tiles of the root first, then those 128 voxels wide, then those 8 voxels wide, without
  /// inactive tiles of the background's value.
  std::vector<TilePart> tiles;
  GridSummary summary;
};

struct TopologyWish {
  bool masks = false;
  std::optional<glm::dvec3> background = {};  ///< inactive tiles of the background have this value
};

/// Reads the topology of a grid from the stream, which is at its tree, in a few bytes a leaf: no
/// node is made. The file's format must be 222 or later. The grid, which is empty, gets the tree's
/// background. Throws if the file is damaged.
Topology read_topology(openvdb::GridBase& empty, std::istream& stream,
                       const TopologyWish& wish = {});

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

/// Such a function, by the value of each voxel.
template <typename ValueOf>
auto each_voxel(const ValueOf& value_of) {
  return [value_of](auto* values) {
    for (std::size_t i = 0; i < kLeafVoxels; ++i)
      values[i] = static_cast<std::decay_t<decltype(*values)>>(value_of(i));
  };
}

/// How many points each voxel of a leaf has.
using PointCounts = std::array<std::int32_t, kLeafVoxels>;

/// The same from the offsets behind each voxel's last point. Throws openvdb::IoError.
template <typename EndOf>
PointCounts point_counts(const EndOf& end_of) {
  PointCounts counts;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const std::uint32_t end = end_of(i), count = end - last;
    if (end < last || count > std::uint32_t(std::numeric_limits<std::int32_t>::max()))
      throw openvdb::IoError("its points are out of order");
    counts[i] = std::int32_t(count);
    last = end;
  }
  return counts;
}

}  // namespace psivox::vdb
