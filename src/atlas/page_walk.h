#pragma once

#include "atlas/atlas.h"

namespace psivox {

/// Calls visit(entry, first, width) for the entries of a page table but children and what is empty:
/// the first brick that it stands for, relative to the table's, and how many along each axis.
template <typename Visit>
void for_entries(const PageTable& pages, const Visit& visit) {
  const auto walk = [&](const auto& self, std::size_t index, const glm::ivec3& size, int level,
                        const glm::ivec3& first) -> void {
    const int width = 1 << (3 * level);
    for_points({glm::ivec3(0), size - 1}, [&](const glm::ivec3& in_table) {
      const std::uint32_t entry = pages.entries[index++];
      const glm::ivec3 at = first + in_table * width;
      if (entry_kind(entry) == EntryKind::child)
        self(self, entry_payload(entry), glm::ivec3(8), level - 1, at);
      else if (entry_kind(entry) != EntryKind::empty)
        visit(entry, at, width);
    });
  };
  walk(walk, 0, pages.top_size, pages.levels - 1, glm::ivec3(0));
}

}  // namespace psivox
