#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

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

/// The voxels of a leaf, inside the domain, that weigh more than 0, by the leaf's parts.
struct LeafWeights {
  float least = 0, greatest = 0;           ///< bounds of their weights
  std::array<float, 8> amounts{};          ///< sums of the weights of each part, over 512
  std::array<std::uint32_t, 8> corners{};  ///< of each part's box in the leaf, three bits each

  glm::ivec3 low(std::size_t part) const { return corner(corners[part]); }
  glm::ivec3 high(std::size_t part) const { return corner(corners[part] >> 9); }
  void set_box(std::size_t part, const glm::ivec3& low, const glm::ivec3& high) {
    corners[part] = packed(low) | packed(high) << 9;
  }

  /// Whether some of them, but not all, may weigh as much as that.
  bool is_cut_by(double weight) const {
    return double(greatest) >= weight && double(least) < weight;
  }

 private:
  static std::uint32_t packed(const glm::ivec3& v) {
    return std::uint32_t(v.x << 6 | v.y << 3 | v.z);
  }
  static glm::ivec3 corner(std::uint32_t bits) {
    return {(bits >> 6) & 7, (bits >> 3) & 7, bits & 7};
  }
};

/// What weighs in one part of a leaf, before it is packed.
struct LeafPart {
  double amount = 0;
  unsigned x = 0, y = 0, z = 0;  ///< a bit for each place along the axis

  glm::ivec3 low() const { return {std::countr_zero(x), std::countr_zero(y), std::countr_zero(z)}; }
  glm::ivec3 high() const {
    return glm::ivec3(std::bit_width(x), std::bit_width(y), std::bit_width(z)) - 1;
  }
};

/// The least number that is above 0 and not below `bound`.
template <typename Real>
Real least_from(double bound) {
  auto least = Real(bound);
  if (double(least) < bound) least = std::nextafter(least, std::numeric_limits<Real>::infinity());
  return std::max(least, std::numeric_limits<Real>::denorm_min());
}

/// `faintest`: what weighs less does not count. `take(weight)` is called for each voxel that weighs
/// as much, inside the domain or not.
template <typename Weight, typename Take>
LeafWeights weigh_leaf(const Field& field, const Leaf& leaf, const Weight& weight, double faintest,
                       const Take& take) {
  using Real = std::invoke_result_t<Weight, const float*>;
  const auto threshold = least_from<Real>(faintest);
  const int channels = field.channels;
  const Box inside{field.domain().min - leaf.origin, field.domain().max - leaf.origin};
  const CubeLattice lattice(field);
  const OrderedValues values(field, leaf);
  std::array<LeafPart, 8> parts;
  Real least = std::numeric_limits<Real>::infinity(), greatest = 0;
  // voxels from..to - 1 of a row along z, which belong to one part
  const auto weigh_row = [&](int x, int y, int from, int to, LeafPart& part) {
    const float* const row = values.data() + (x * 8 + y) * 8 * channels;
    const bool outside =
        x < inside.min.x || x > inside.max.x || y < inside.min.y || y > inside.max.y;
    const int first = outside ? 8 : inside.min.z, last = inside.max.z;
    double amount = 0;
    unsigned places = 0;
    for (int z = from; z < to; ++z) {
      const Real w = weight(row + z * channels);
      if (!(w >= threshold)) continue;
      take(w);
      if (z < first || z > last) continue;
      least = std::min(least, w);
      greatest = std::max(greatest, w);
      amount += double(w);
      places |= 1u << z;
    }
    if (places == 0) return;
    part.amount += amount;
    part.x |= 1u << x;
    part.y |= 1u << y;
    part.z |= places;
  };
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) {
      const int cut = lattice.offset.z;
      weigh_row(x, y, 0, cut, parts[lattice.part_of({x, y, 0})]);
      weigh_row(x, y, cut, 8, parts[lattice.part_of({x, y, cut})]);
    }
  LeafWeights found;
  if (!(greatest > 0)) return found;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    found.amounts[n] = float(parts[n].amount / 512);  // no more than the greatest weight
    if (parts[n].amount > 0) found.set_box(n, parts[n].low(), parts[n].high());
  }
  found.least = float(least);
  if (double(found.least) > double(least)) found.least = std::nextafter(found.least, 0.0f);
  found.greatest = float(greatest);
  if (double(found.greatest) < double(greatest))
    found.greatest = std::nextafter(found.greatest, std::numeric_limits<float>::infinity());
  return found;
}

}  // namespace psivox
