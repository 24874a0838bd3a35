#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <set>

#include "psivox/field.h"

namespace psivox::test {

/// Bytes of the pages in memory that hold values of a field's leaves.
inline std::size_t resident_bytes(const Field& field) {
  const auto page = std::uintptr_t(sysconf(_SC_PAGESIZE));
  std::set<std::uintptr_t> pages;
  for (const Leaf& leaf : field.leaves) {
    const auto first = reinterpret_cast<std::uintptr_t>(leaf.values);
    for (auto at = first / page; at * page < first + 512 * sizeof(float); ++at) pages.insert(at);
  }
  std::size_t bytes = 0;
  for (const std::uintptr_t at : pages) {
    unsigned char there = 0;
    if (mincore(reinterpret_cast<void*>(at * page), page, &there) == 0 && there & 1) bytes += page;
  }
  return bytes;
}

/// The least of it that is left where values were discarded: a page at either end of the array,
/// which other things share.
inline std::size_t discarded_bytes() { return 2 * std::size_t(sysconf(_SC_PAGESIZE)); }

}  // namespace psivox::test
