#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace psivox {

/// Hash of a voxel's coordinates, for containers.
struct VoxelHash {
  std::size_t operator()(const glm::ivec3& v) const {
    std::uint64_t h = 0;
    for (int axis = 0; axis < 3; ++axis) h = (h ^ std::uint32_t(v[axis])) * 0x9E3779B97F4A7C15ull;
    return std::size_t(h ^ (h >> 32));
  }
};

/// Open-addressing map from a block's coordinates to a number, for blocks that are inserted once
/// and found millions of times.
class BlockMap {
 public:
  static constexpr std::int32_t none = -1;

  explicit BlockMap(std::size_t expected = 0) : slots_(std::bit_ceil(2 * expected + 16)) {}

  std::int32_t find(const glm::ivec3& at) const { return slots_[place(at)].number; }

  /// Inserts `number` unless the block is there; returns what is there now.
  std::int32_t insert(const glm::ivec3& at, std::int32_t number) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[place(at)];
    if (slot.number != none) return slot.number;
    slot = {at, number};
    ++size_;
    return number;
  }

 private:
  struct Slot {
    glm::ivec3 at{0};
    std::int32_t number = none;
  };

  /// The slot that has the block, or where it would be.
  std::size_t place(const glm::ivec3& at) const {
    const std::size_t last = slots_.size() - 1;
    std::size_t i = VoxelHash()(at) & last;
    while (slots_[i].number != none && slots_[i].at != at) i = (i + 1) & last;
    return i;
  }
  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.number != none) slots_[place(slot.at)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

}  // namespace psivox
