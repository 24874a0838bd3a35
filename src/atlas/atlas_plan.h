#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "atlas/atlas.h"
#include "atlas/brick_source.h"

namespace psivox::atlas {

/// Fills a page table entry by entry, then finds the skip distances of the empty ones. Tables below
/// the top one that are equal are stored once.
class PageTableBuilder {
 public:
  /// Covers bricks [min, max], with enough levels to keep the top table within top_entries.
  PageTableBuilder(const glm::ivec3& min_brick, const glm::ivec3& max_brick,
                   std::uint64_t top_entries);

  /// Bricks outside the table are ignored. Throws Error(memory) if it would have more entries than
  /// a payload counts.
  void set_box(const glm::ivec3& min_brick, const glm::ivec3& max_brick, std::uint32_t entry);

  PageTable finish();

 private:
  /// The change of an entry by a box: the entry, its level, and the part of it that the box covers.
  using Change = std::array<std::int64_t, 8>;
  using Changes = std::map<Change, std::uint32_t>;

  void set_box(std::size_t base, const glm::ivec3& size, int level, const glm::ivec3& lo,
               const glm::ivec3& hi, std::uint32_t entry, Changes* changes);
  std::size_t child(std::size_t index);
  std::size_t top_count() const;
  std::size_t number(std::uint32_t child) const;
  void merge_equal();

  PageTable table_;
  glm::ivec3 max_;            ///< last brick, from table_.min
  std::size_t merge_at_;      ///< entries from which on equal tables are looked for
  std::vector<bool> shared_;  ///< tables below the top one that several entries may refer to
};

/// Chebyshev distance of every empty entry to the nearest other one; `outside_empty` tells whether
/// everything outside the table is empty. It never exceeds the payload.
void set_skip_distances(std::uint32_t* entries, const glm::ivec3& size, bool outside_empty);

/// Topology of an atlas: everything except the texels.
struct Plan {
  BrickSource source;
  BrickAtlas atlas;
};

Plan make_plan(const Field& field, const AtlasOptions& options);

std::uint64_t texel_bytes(std::size_t bricks, int channels);

}  // namespace psivox::atlas
