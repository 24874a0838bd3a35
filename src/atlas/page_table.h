#pragma once

#include <glm/vec3.hpp>

#include "psivox/atlas.h"

namespace psivox::atlas {

/// Fills a page table entry by entry, then finds the skip distances of the empty ones.
class PageTableBuilder {
 public:
  /// Covers bricks [min, max], with enough levels to keep the top table within top_entries.
  PageTableBuilder(const glm::ivec3& min_brick, const glm::ivec3& max_brick,
                   std::uint64_t top_entries);

  /// The table that the entries of these calls need; bricks outside it are ignored.
  void set_brick(const glm::ivec3& brick, std::uint32_t entry);
  void set_box(const glm::ivec3& min_brick, const glm::ivec3& max_brick, std::uint32_t entry);

  PageTable finish();

 private:
  void set_box(std::size_t base, const glm::ivec3& size, int level, const glm::ivec3& lo,
               const glm::ivec3& hi, std::uint32_t entry);
  std::size_t child(std::size_t index);

  PageTable table_;
  glm::ivec3 max_;  ///< last brick, from table_.min
};

/// Chebyshev distance of every empty entry to the nearest other one; `outside_empty` tells whether
/// everything outside the table is empty. It never exceeds the payload.
void set_skip_distances(std::uint32_t* entries, const glm::ivec3& size, bool outside_empty);

}  // namespace psivox::atlas
