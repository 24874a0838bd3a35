#include "atlas/atlas_plan.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <string_view>
#include <unordered_map>

#include "field/index_space.h"
#include "psivox/error.h"

namespace psivox::atlas {
namespace {

constexpr int child_width = 8;
constexpr std::size_t child_entries = 512;
constexpr std::size_t few_entries = std::size_t{1} << 22;  // 16 MiB

std::size_t index_of(const glm::ivec3& at, const glm::ivec3& size) {
  return (std::size_t(at.x) * std::size_t(size.y) + std::size_t(at.y)) * std::size_t(size.z) +
         std::size_t(at.z);
}

}  // namespace

PageTableBuilder::PageTableBuilder(const glm::ivec3& min_brick, const glm::ivec3& max_brick,
                                   std::uint64_t top_entries)
    : max_(max_brick - min_brick) {
  table_.min = min_brick * brick_cells;
  const glm::ivec3 bricks = max_ + 1;
  for (table_.levels = 1;; ++table_.levels) {
    const int span = 1 << (3 * (table_.levels - 1));
    table_.top_size = (bricks + (span - 1)) / span;
    if (top_count() <= top_entries) break;
  }
  table_.entries.assign(top_count(), make_entry(EntryKind::empty, 1));
  merge_at_ = top_count() + few_entries;
}

/// Number of a table, by the entry above it.
std::size_t PageTableBuilder::number(std::uint32_t child) const {
  return (entry_payload(child) - top_count()) / child_entries;
}

std::size_t PageTableBuilder::top_count() const {
  const glm::ivec3& n = table_.top_size;
  return std::size_t(n.x) * std::size_t(n.y) * std::size_t(n.z);
}

/// Index of the table below an entry, for this entry alone. If there is none, makes one and fills
/// it with the entry.
std::size_t PageTableBuilder::child(std::size_t index) {
  const std::uint32_t entry = table_.entries[index];
  const bool is_child = entry_kind(entry) == EntryKind::child;
  if (is_child && !shared_[number(entry)]) return entry_payload(entry);
  const std::size_t base = table_.entries.size();
  if (base + child_entries > std::size_t{1} << entry_payload_bits)
    throw Error(ExitCode::memory,
                "the grid is spread over more blocks of 64^3 voxels than a page table holds");
  table_.entries.resize(base + child_entries, entry);
  if (is_child) {
    const std::span all(table_.entries);
    std::ranges::copy(all.subspan(entry_payload(entry), child_entries), &all[base]);
    for (const std::uint32_t below : all.subspan(base))
      if (entry_kind(below) == EntryKind::child) shared_[number(below)] = true;
  }
  shared_.push_back(false);
  table_.entries[index] = make_entry(EntryKind::child, std::uint32_t(base));
  return base;
}

void PageTableBuilder::set_box(const glm::ivec3& min_brick, const glm::ivec3& max_brick,
                               std::uint32_t entry) {
  const glm::ivec3 origin = table_.min / brick_cells;
  const glm::ivec3 lo = glm::max(min_brick - origin, glm::ivec3(0));
  const glm::ivec3 hi = glm::min(max_brick - origin, max_);
  if (lo.x > hi.x || lo.y > hi.y || lo.z > hi.z) return;
  if (table_.entries.size() > merge_at_) {
    merge_equal();
    merge_at_ = std::max(top_count() + few_entries, 2 * table_.entries.size());
  }
  Changes changes;
  const glm::dvec3 tables((hi - lo) / child_width + 1);
  constexpr double few = 64;  // tables that are changed sooner than compared
  Changes* keep = tables.x * tables.y * tables.z > few ? &changes : nullptr;
  set_box(0, table_.top_size, table_.levels - 1, lo, hi, entry, keep);
}

/// Sets bricks [lo, hi], relative to the table at `base`, whose entries span 8^level bricks. Equal
/// changes of entries, if they are kept, have the same table below as result.
void PageTableBuilder::set_box(std::size_t base, const glm::ivec3& size, int level,
                               const glm::ivec3& lo, const glm::ivec3& hi, std::uint32_t entry,
                               Changes* changes) {
  const int shift = 3 * level;
  const int span = 1 << shift;
  for_points({lo >> shift, hi >> shift}, [&](const glm::ivec3& at) {
    const std::size_t index = base + index_of(at, size);
    const glm::ivec3 first = at * span;
    const glm::ivec3 from = glm::max(lo - first, glm::ivec3(0));
    const glm::ivec3 to = glm::min(hi - first, glm::ivec3(span - 1));
    if (from == glm::ivec3(0) && to == glm::ivec3(span - 1)) {
      table_.entries[index] = entry;
      return;
    }
    const Change change{table_.entries[index], level, from.x, from.y, from.z, to.x, to.y, to.z};
    if (changes)
      if (const auto made = changes->find(change); made != changes->end()) {
        table_.entries[index] = made->second;
        shared_[number(made->second)] = true;
        return;
      }
    set_box(child(index), glm::ivec3(child_width), level - 1, from, to, entry, changes);
    if (changes) changes->emplace(change, table_.entries[index]);
  });
}

/// Stores equal tables once. Those below others are compared first.
void PageTableBuilder::merge_equal() {
  std::vector<std::uint32_t>& entries = table_.entries;
  const std::size_t top = top_count();
  constexpr std::uint32_t none = ~0u;
  std::vector<std::uint32_t> equal(shared_.size(), none);  // the first table that is equal
  std::vector<bool> again(shared_.size());                 // whether several entries refer to it
  std::unordered_map<std::string_view, std::uint32_t> distinct;
  const auto visit = [&](const auto& self, std::size_t base, std::size_t count, int level) -> void {
    for (std::uint32_t& entry : std::span(entries).subspan(base, count)) {
      if (entry_kind(entry) != EntryKind::child) continue;
      const std::size_t table = number(entry), first = top + table * child_entries;
      if (equal[table] != none) {
        again[equal[table]] = true;
      } else {
        if (level > 1) self(self, first, child_entries, level - 1);
        const std::string_view bytes(reinterpret_cast<const char*>(&entries[first]),
                                     child_entries * sizeof(std::uint32_t));
        const auto [found, is_new] = distinct.try_emplace(bytes, std::uint32_t(table));
        equal[table] = found->second;
        if (!is_new) again[equal[table]] = true;
      }
      entry = make_entry(EntryKind::child, std::uint32_t(top + equal[table] * child_entries));
    }
  };
  visit(visit, 0, top, table_.levels - 1);
  std::vector<std::uint32_t> moved(equal.size(), none);
  std::size_t end = top;
  shared_.clear();
  for (std::size_t table = 0; table < equal.size(); ++table) {
    if (equal[table] != table) continue;
    const auto from = entries.begin() + std::ptrdiff_t(top + table * child_entries);
    std::copy_n(from, child_entries, entries.begin() + std::ptrdiff_t(end));
    moved[table] = std::uint32_t(end);
    shared_.push_back(again[table]);
    end += child_entries;
  }
  entries.resize(end);
  for (std::uint32_t& entry : entries)
    if (entry_kind(entry) == EntryKind::child)
      entry = make_entry(EntryKind::child, moved[number(entry)]);
}

PageTable PageTableBuilder::finish() {
  merge_equal();
  table_.entries.shrink_to_fit();
  set_skip_distances(table_.entries.data(), table_.top_size, true);
  for (std::size_t i = top_count(); i < table_.entries.size(); i += child_entries)
    set_skip_distances(table_.entries.data() + i, glm::ivec3(child_width), false);
  return std::move(table_);
}

/// The two-pass chamfer over all 26 neighbours is exact for the Chebyshev metric.
void set_skip_distances(std::uint32_t* entries, const glm::ivec3& size, bool outside_empty) {
  constexpr std::uint32_t far = 1u << 12;  // keeps the skip in voxels within an int
  const auto distance = [&](const glm::ivec3& at) -> std::uint32_t {
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= size.x || at.y >= size.y || at.z >= size.z)
      return outside_empty ? far : 0;
    const std::uint32_t entry = entries[index_of(at, size)];
    return entry_kind(entry) == EntryKind::empty ? entry_payload(entry) : 0;
  };
  const auto relax = [&](const glm::ivec3& at, int direction, bool first) {
    std::uint32_t& entry = entries[index_of(at, size)];
    if (entry_kind(entry) != EntryKind::empty) return;
    std::uint32_t best = first ? far : entry_payload(entry);
    for (int i = 0; i < 13; ++i) {  // half of the 26 neighbours: those before in z-fastest order
      const glm::ivec3 step(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      best = std::min(best, distance(at + step * direction) + 1);
    }
    entry = make_entry(EntryKind::empty, best);
  };
  // Each pass reads only the half of the neighbours that it has already visited; entries still hold
  // their initial payload when the first pass comes to them.
  const Box all{glm::ivec3(0), size - 1};
  for_points(all, [&](const glm::ivec3& at) { relax(at, 1, true); });
  for_points(all, [&](const glm::ivec3& at) { relax(all.max - at, -1, false); });
}

}  // namespace psivox::atlas
