#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "psivox/camera.h"
#include "psivox/leaf_values.h"
#include "psivox/medium.h"

// What the voxels of leaves weigh: their attenuation or emission.

namespace psivox {

/// Weights of 8 voxels along z.
using RowWeights = std::array<double, 8>;

/// Counts voxels by their weight, four bins to a power of two.
class WeightCounts {
 public:
  void add(double weight, std::uint64_t voxels) {
    if (weight > 0) counts_[bin_of(weight)] += voxels;
  }
  void add(const RowWeights& weights) {
    std::uint64_t weightless = 0;
    for (const double weight : weights) {
      ++counts_[bin_of(weight > 0 ? weight : 0)];
      weightless += !(weight > 0);
    }
    counts_[0] -= weightless;
  }
  /// What has been counted as infinite has another weight.
  void replace_infinite(double weight) {
    const std::uint64_t voxels =
        std::exchange(counts_[bin_of(std::numeric_limits<double>::infinity())], 0);
    add(weight, voxels);
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
  static std::size_t bin_of(double weight) {
    return std::bit_cast<std::uint32_t>(float(weight)) >> 21;
  }
  static double begin_of(std::size_t bin) {
    return double(std::bit_cast<float>(std::uint32_t(bin) << 21));
  }

  std::array<std::uint64_t, 1024> counts_{};  // of the positive floats, by their upper 11 bits
};

/// Cubes of 8^3 voxels that begin at the active box, wherever a tree's leaves begin: what is found
/// in them depends on the values alone. A leaf has parts of up to eight.
struct CellLattice {
  explicit CellLattice(const Field& field)
      : first(field.active_box.min), offset(field.active_box.min & 7) {}

  glm::ivec3 cell_of(const glm::ivec3& voxel) const { return (voxel - first) >> 3; }
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
  std::array<float, 8> amounts{};          ///< sums of the weights of each part
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

/// `faintest`: what weighs less does not count. `take(weights)` is called for each row. Loops over
/// a row have no branches: this is the longest look at a file's values, and compilers vectorise it.
template <typename Weight, typename Take>
LeafWeights weigh_leaf(const Field& field, const Leaf& leaf, const Weight& weight, double faintest,
                       const Take& take) {
  struct Part {
    double amount = 0;
    glm::ivec3 low{7}, high{0};
  };
  constexpr double none = std::numeric_limits<double>::infinity();
  const Box domain = field.domain();
  const CellLattice lattice(field);
  const bool all_inside = domain.contains(leaf.origin) && domain.contains(leaf.origin + 7);
  const OrderedValues values(field, leaf);
  std::array<Part, 8> parts;
  RowWeights row, counted, lows, highs{};  // the last two: of all rows
  lows.fill(none);
  // voxels from..to - 1 of a row, which belong to one part
  const auto add_row = [&](int x, int y, std::size_t from, std::size_t to) {
    double amount = 0;
    for (std::size_t z = from; z < to; ++z) amount += counted[z];
    if (!(amount > 0)) return;
    std::size_t first = from, last = to - 1;
    while (!(counted[first] > 0)) ++first;
    while (!(counted[last] > 0)) --last;
    Part& part = parts[lattice.part_of({x, y, int(from)})];
    part.amount += amount;
    part.low = glm::min(part.low, glm::ivec3(x, y, first));
    part.high = glm::max(part.high, glm::ivec3(x, y, last));
  };
  const auto middle = std::size_t(lattice.offset.z);
  const float* value = values.data();
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) {
      for (std::size_t z = 0; z < 8; ++z, value += field.channels) row[z] = weight(value);
      take(row);
      if (!all_inside)
        for (int z = 0; z < 8; ++z)
          if (!domain.contains(leaf.origin + glm::ivec3(x, y, z))) row[std::size_t(z)] = 0;
      for (std::size_t z = 0; z < 8; ++z) {
        const bool counts = row[z] > 0 && row[z] >= faintest;
        counted[z] = counts ? row[z] : 0;
        lows[z] = std::min(lows[z], counts ? row[z] : none);
        highs[z] = std::max(highs[z], counted[z]);
      }
      if (middle > 0) add_row(x, y, 0, middle);
      add_row(x, y, middle, 8);
    }
  const double least = *std::ranges::min_element(lows), greatest = *std::ranges::max_element(highs);
  LeafWeights found;
  if (!(greatest > 0)) return found;
  for (std::size_t n = 0; n < parts.size(); ++n) {
    found.amounts[n] = float(parts[n].amount);
    if (parts[n].amount > 0) found.set_box(n, parts[n].low, parts[n].high);
  }
  const float infinity = std::numeric_limits<float>::infinity();
  found.least = std::isinf(greatest) ? 0 : float(least);  // it will be another value
  if (double(found.least) > least) found.least = std::nextafter(found.least, 0.0f);
  found.greatest = float(greatest);
  if (double(found.greatest) < greatest) found.greatest = std::nextafter(found.greatest, infinity);
  return found;
}

/// What is found in some leaves, one after another, and how many voxels weigh how much.
struct WeighedLeaves {
  std::vector<LeafWeights> leaves;
  WeightCounts counts;

  template <typename Weight>
  void add(const Field& field, std::span<const Leaf> some, const Weight& weight) {
    const std::size_t first = leaves.size();
    leaves.resize(first + some.size());
    counts += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, some.size(), 64), WeightCounts(),
        [&](const auto& range, WeightCounts own) {
          for (std::size_t n = range.begin(); n != range.end(); ++n)
            leaves[first + n] =
                weigh_leaf(field, some[n], weight, 0, [&](const RowWeights& row) { own.add(row); });
          return own;
        },
        [](WeightCounts a, const WeightCounts& b) { return a += b; });
  }
};

/// The weight of a density without a transfer function.
struct ValueWeight {
  double operator()(const float* value) const { return double(*value); }
};

/// The blocks of the medium that are visible under the mode: leaves and tiles, shrunk to the voxels
/// whose attenuation or emission is at least a thousandth of the grid's greatest, and grown by the
/// voxel that the interpolation reaches. The greatest leaves out the highest thousandth of the
/// voxels, so that one odd value does not hide all others. Of more than 131,072 leaves, those in a
/// cube of 16, 32, ... voxels are one block. The whole domain if nothing is visible.
/// `known`: what the density's leaves weigh by their values, if that is known.
Subject subject_of(const Medium& medium, Mode mode, const WeighedLeaves* known = nullptr);

}  // namespace psivox
