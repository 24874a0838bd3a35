#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "grid_file.h"

// NanoVDB keeps a grid as one block of bytes whose nodes point to each other by offsets. The block
// comes from a file that can hold anything, so each offset and each size is checked before it is
// followed, and no code of NanoVDB that follows them is used.

namespace psivox::vdb {

/// How NanoVDB stores a grid.
struct NanoType {
  std::string name;         ///< NanoVDB's: float, Fp8, ...
  std::string grid_type{};  ///< OpenVDB's type with these values; empty if it cannot be rendered
  bool quantised = false;
};

/// By the numbers of its type and class, nanovdb::GridType and nanovdb::GridClass.
NanoType nano_type(std::uint32_t type, std::uint32_t grid_class);

/// A grid of a .nvdb, whose type can be rendered.
struct NanoSource {
  const GridFile& file;
  const GridEntry& entry;
  bool marked;  ///< see GridFile::open
  GridHead head;
  std::uint32_t type, grid_class;
  std::span<const char> bytes;         ///< the first is aligned to 32 bytes
  std::shared_ptr<const void> memory;  ///< keeps them alive
};

/// Throws std::runtime_error if a node is not within the bytes.
std::unique_ptr<FileGrid> nano_grid(const NanoSource& source);

}  // namespace psivox::vdb
