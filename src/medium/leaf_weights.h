#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "field/index_space.h"
#include "field/leaf_values.h"
#include "psivox/field.h"

namespace psivox {

/// Counts voxels by their weight, four bins to a power of two.
class WeightCounts {
 public:
  template <typename Real>
  void add(Real weight, std::uint64_t voxels) {
    if (weight > 0) counts_[bin_of(weight)] += voxels;
  }
  WeightCounts& operator+=(const WeightCounts& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    return *this;
  }
  /// Lower end of the bin in which lies the weight that a share of the voxels exceeds; 0 if there
  /// are none.
  double exceeded_by(double share) const {
    std::uint64_t all = 0, above = 0;
    for (const std::uint64_t count : counts_) all += count;
    for (std::size_t i = counts_.size(); i-- > 0;) {
      above += counts_[i];
      if (above > 0 && double(above) >= share * double(all)) return begin_of(i);
    }
    return 0;
  }

 private:
  template <typename Real>
  static std::size_t bin_of(Real weight) {
    return std::bit_cast<std::uint32_t>(float(weight)) >> 21;
  }
  static double begin_of(std::size_t bin) {
    return double(std::bit_cast<float>(std::uint32_t(bin) << 21));
  }

  std::array<std::uint64_t, 1024> counts_{};  // of the positive floats, by their upper 11 bits
};

/// Cubes of 8^3 voxels that begin at the active box, wherever a tree's leaves begin: what is found
/// in them depends on the values alone. A leaf has parts of up to eight.
struct CubeLattice {
  explicit CubeLattice(const Field& field)
      : first(field.active_box.min), offset(field.active_box.min & 7) {}

  glm::ivec3 cube_of(const glm::ivec3& voxel) const { return (voxel - first) >> 3; }
  /// Number of a leaf's part, 0 to 7, that has a voxel of the leaf.
  std::size_t part_of(const glm::ivec3& place) const {
    std::size_t part = 0;
    for (int axis = 0; axis < 3; ++axis)
      part = 2 * part + (offset[axis] > 0 && place[axis] >= offset[axis]);
    return part;
  }

  glm::ivec3 first, offset;
};

/// The voxels of a part of a leaf, inside the domain, that weigh enough.
struct LeafPart {
  double amount = 0;             ///< sum of their weights
  unsigned x = 0, y = 0, z = 0;  ///< a bit for each place along the axis

  glm::ivec3 low() const { return {std::countr_zero(x), std::countr_zero(y), std::countr_zero(z)}; }
  glm::ivec3 high() const {
    return glm::ivec3(std::bit_width(x), std::bit_width(y), std::bit_width(z)) - 1;
  }
};
using LeafParts = std::array<LeafPart, 8>;

/// The parts of a leaf by their numbers. `faintest`, above 0: what weighs less does not count.
template <typename Weight>
LeafParts weigh_leaf(const Field& field, const Leaf& leaf, const Weight& weight, double faintest) {
  const int channels = field.channels;
  const Box domain = field.domain();
  const Box inside =
      common({domain.min - leaf.origin, domain.max - leaf.origin}, {glm::ivec3(0), glm::ivec3(7)});
  const CubeLattice lattice(field);
  const OrderedValues values(field, leaf);
  LeafParts parts;
  // voxels from..to of a row along z, which belong to one part
  const auto weigh_row = [&](int x, int y, int from, int to, LeafPart& part) {
    const float* const row = values.data() + (x * 8 + y) * 8 * channels;
    double amount = 0;
    unsigned places = 0;
    for (int z = from; z <= to; ++z) {
      const auto w = double(weight(row + z * channels));
      if (!(w >= faintest)) continue;
      amount += w;
      places |= 1u << z;
    }
    if (places == 0) return;
    part.amount += amount;
    part.x |= 1u << x;
    part.y |= 1u << y;
    part.z |= places;
  };
  const int cut = lattice.offset.z;
  for (int x = inside.min.x; x <= inside.max.x; ++x)
    for (int y = inside.min.y; y <= inside.max.y; ++y) {
      weigh_row(x, y, inside.min.z, std::min(inside.max.z, cut - 1),
                parts[lattice.part_of({x, y, 0})]);
      weigh_row(x, y, std::max(inside.min.z, cut), inside.max.z,
                parts[lattice.part_of({x, y, cut})]);
    }
  return parts;
}

}  // namespace psivox
