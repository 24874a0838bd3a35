#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "psivox/field.h"

// Values of a field whose leaves may lie in an array, or stay in its file.

namespace psivox {

/// A voxel of a leaf of 8^3, by its number from 0 to 511 in OpenVDB's order.
inline glm::ivec3 leaf_voxel(int i) { return {i >> 6, i >> 3 & 7, i & 7}; }

/// Whether a voxel of an array has data that is not 0.
inline bool is_active(float value) { return value != 0 && value > -HUGE_VALF; }

/// Where 8^3 voxels have their values.
struct LeafValues {
  const float* first = nullptr;  ///< of the smallest voxel
  Strides strides{};

  /// The first channel of a voxel, each coordinate from 0 to 7.
  const float* at(const glm::ivec3& voxel) const {
    return first + (voxel.x * strides.x + voxel.y * strides.y + voxel.z * strides.z);
  }
  float channel(int c) const { return first[c * strides.channel]; }  ///< of the smallest voxel
  /// Whether all voxels are one.
  bool is_constant() const { return strides.x == 0 && strides.y == 0 && strides.z == 0; }

  /// The first `count` voxels of the row (x, y), `channels` interleaved: in place, or written to
  /// `room`.
  const float* row(int x, int y, int count, int channels, float* room) const {
    const float* from = at({x, y, 0});
    if (strides.z == channels && strides.channel == 1) return from;
    for (int z = 0; z < count; ++z, from += strides.z)
      for (int c = 0; c < channels; ++c) room[z * channels + c] = from[c * strides.channel];
    return room;
  }
  void copy_row(int x, int y, int count, int channels, float* to) const {
    const float* from = row(x, y, count, channels, to);
    if (from == to) return;
    if (const int floats = count * channels; floats == 8)
      std::memcpy(to, from, 8 * sizeof(float));  // of a size that the compiler knows
    else
      for (int i = 0; i < floats; ++i) to[i] = from[i];
  }
};

/// The values of a leaf that is in memory.
LeafValues values_of(const Field& field, const Leaf& leaf);

/// Copies a leaf's values, or those of its first `size` voxels along each axis, to their places in
/// OpenVDB's order: 512 * channels floats.
void copy_values(const LeafValues& from, int channels, float* to,
                 const glm::ivec3& size = glm::ivec3(8));

/// The values of a leaf in OpenVDB's order: the field's own, or a copy out of its array.
class OrderedValues {
 public:
  OrderedValues(const Field& field, const Leaf& leaf);
  OrderedValues(const OrderedValues&) = delete;
  OrderedValues& operator=(const OrderedValues&) = delete;

  const float* data() const { return values_; }
  float operator[](std::size_t i) const { return values_[i]; }
  const float* begin() const { return values_; }
  const float* end() const { return values_ + size_; }
  std::size_t size() const { return size_; }

 private:
  const float* values_;
  std::size_t size_;  ///< 512 * channels
  std::array<float, 512 * 3> copy_;
};

/// Gives all leaves values of their own: fill(n, values) writes those of one, in all threads.
template <typename Fill>
void fill_leaves(Field& field, const Fill& fill) {
  const std::size_t floats = 512 * std::size_t(field.channels);
  const auto values = std::make_shared_for_overwrite<float[]>(field.leaves.size() * floats);
  tbb::parallel_for(std::size_t{0}, field.leaves.size(), [&](std::size_t n) {
    field.leaves[n].values = values.get() + n * floats;
    fill(n, values.get() + n * floats);
  });
  field.array.reset();
  field.storage = values;
}

/// Bytes of the values of all leaves.
std::uint64_t value_bytes(const Field& field);

/// Throws Error(memory) if the values of leaves are not in memory, for what needs all of them: that
/// may be an option, `light`, which can be left out.
void check_in_memory(const Field& field, const std::string& option = {});

using VisitLeaves = std::function<void(std::span<const Leaf> leaves)>;
using WantLeaf = std::function<bool(const Leaf& leaf)>;

/// Visits the leaves with their values, in their order: all at once if they are in memory, else a
/// few thousand at a time. Those that are not wanted may be left out; by default all are wanted.
void visit_leaves(const Field& field, const VisitLeaves& visit, const WantLeaf& wanted = {});

/// Folds what the leaves have, in all threads: take(found, leaf, values) adds what is in one, and
/// join adds up two sums, each of leaves that follow each other.
template <typename Found, typename Take, typename Join>
Found fold_leaves(const Field& field, const Found& none, const Take& take, const Join& join) {
  Found all = none;
  visit_leaves(field, [&](std::span<const Leaf> leaves) {
    const Found found = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, leaves.size(), 64), none,
        [&](const auto& some, Found own) {
          for (std::size_t n = some.begin(); n != some.end(); ++n)
            take(own, leaves[n], OrderedValues(field, leaves[n]));
          return own;
        },
        join);
    all = join(std::move(all), found);
  });
  return all;
}

/// Sorts blocks in the order of OpenVDB's trees, in which a field's leaves are: by nodes of 4096
/// voxels, of 128, of 8.
using TreeOrder = std::array<int, 9>;

inline TreeOrder tree_order(const glm::ivec3& origin) {
  TreeOrder key{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = std::size_t(axis);
    key[at] = origin[axis] >> 12;
    key[at + 3] = (origin[axis] >> 7) & 31;
    key[at + 6] = (origin[axis] >> 3) & 15;
  }
  return key;
}

/// The field with those leaves only that have voxels in the box, or are wanted, and their values in
/// memory. It keeps all tiles and everything else.
Field part_of_field(const Field& field, const Box& voxels);
Field part_of_field(const Field& field, const WantLeaf& wanted);

}  // namespace psivox
