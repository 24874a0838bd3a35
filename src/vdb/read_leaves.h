#pragma once

#include <openvdb/openvdb.h>

#include <istream>

#include "file_buffer.h"

namespace psivox::vdb {

/// Reads the values of a grid whose topology has just been read from `stream`, which has
/// this buffer, and leaves the stream behind them. All threads decompress. The grid's type must be
/// one of SupportedGrids, the file's format 222 or later.
void read_leaves(openvdb::GridBase& grid, std::istream& stream, FileBuffer& buffer);

}  // namespace psivox::vdb
