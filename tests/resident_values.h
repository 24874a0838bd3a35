#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <set>

#include "psivox/field.h"

namespace psivox::test {

/// Numbers of the pages that hold an array.
inline std::set<std::uintptr_t> pages_of(const void* array, std::size_t bytes) {
  const auto page = std::uintptr_t(sysconf(_SC_PAGESIZE));
  const auto first = reinterpret_cast<std::uintptr_t>(array);
  std::set<std::uintptr_t> pages;
  for (auto at = first / page; at * page < first + bytes; ++at) pages.insert(at);
  return pages;
}

/// Bytes of those that are in memory.
inline std::size_t resident_bytes(const std::set<std::uintptr_t>& pages) {
  const auto page = std::uintptr_t(sysconf(_SC_PAGESIZE));
  std::size_t bytes = 0;
  for (const std::uintptr_t at : pages) {
    unsigned char there = 0;
    if (mincore(reinterpret_cast<void*>(at * page), page, &there) == 0 && there & 1) bytes += page;
  }
  return bytes;
}

inline std::size_t resident_bytes(const void* array, std::size_t bytes) {
  return resident_bytes(pages_of(array, bytes));
}

/// The same of all values of a field's leaves.
inline std::size_t resident_bytes(const Field& field) {
  std::set<std::uintptr_t> pages;
  for (const Leaf& leaf : field.leaves) pages.merge(pages_of(leaf.values, 512 * sizeof(float)));
  return resident_bytes(pages);
}

/// The least of it that is left where values were discarded: a page at either end of the array,
/// which other things share.
inline std::size_t discarded_bytes() { return 2 * std::size_t(sysconf(_SC_PAGESIZE)); }

}  // namespace psivox::test
