#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace psivox::atlas {

/// Open-addressing map from a block's coordinates to a number, for blocks that are inserted once
/// and found millions of times. Coordinates count modulo 2^21, so all must lie within 2^21 of each
/// other (2^24 voxels; BrickSource::check_width checks it).
class BlockMap {
 public:
  static constexpr std::int32_t none = -1;

  explicit BlockMap(std::size_t expected = 0) {
    while (std::size_t{1} << bits_ < expected * 2) ++bits_;
    slots_.resize(std::size_t{1} << bits_);
  }

  std::int32_t find(const glm::ivec3& at) const {
    const std::uint64_t key = pack(at);
    for (std::size_t i = hash(key);; ++i) {
      const Slot& slot = slots_[i & (slots_.size() - 1)];
      if (slot.value == none || slot.key() == key) return slot.value;
    }
  }

  /// Inserts `value` unless the block is there; returns what is there now.
  std::int32_t insert(const glm::ivec3& at, std::int32_t value) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    const std::uint64_t key = pack(at);
    for (std::size_t i = hash(key);; ++i) {
      Slot& slot = slots_[i & (slots_.size() - 1)];
      if (slot.value == none) {
        slot = {std::uint32_t(key), std::uint32_t(key >> 32), value};
        ++size_;
        return value;
      }
      if (slot.key() == key) return slot.value;
    }
  }

 private:
  /// 12 bytes.
  struct Slot {
    std::uint32_t key_low = 0, key_high = 0;
    std::int32_t value = none;

    std::uint64_t key() const { return std::uint64_t{key_high} << 32 | key_low; }
  };

  static std::uint64_t pack(const glm::ivec3& at) {
    constexpr std::uint64_t mask = (1u << 21) - 1;
    return (std::uint64_t(std::uint32_t(at.x)) & mask) << 42 |
           (std::uint64_t(std::uint32_t(at.y)) & mask) << 21 |
           (std::uint64_t(std::uint32_t(at.z)) & mask);
  }
  /// Fibonacci hashing: the top bits alone follow from all of the key's.
  std::size_t hash(std::uint64_t key) const {
    return std::size_t((key * 0x9E3779B97F4A7C15ull) >> (64 - bits_));
  }
  void grow() {
    std::vector<Slot> old(slots_.size() * 2);
    old.swap(slots_);
    ++bits_;
    for (const Slot& slot : old) {
      if (slot.value == none) continue;
      std::size_t i = hash(slot.key());
      while (slots_[i & (slots_.size() - 1)].value != none) ++i;
      slots_[i & (slots_.size() - 1)] = slot;
    }
  }

  int bits_ = 4;  ///< of a slot's number
  std::vector<Slot> slots_;
  std::size_t size_ = 0;
};

}  // namespace psivox::atlas
