#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "topology.h"
#include "value_block.h"

namespace psivox::vdb {

/// How many bytes each leaf's values take in the file, as the grid's metadata for delayed loading
/// say: their kinds, and their compressed lengths. Empty if those metadata do not have all of it,
/// or cannot be right. `value_bytes` is the size of a value in the grid's own type. They are to be
/// checked where a leaf is read, for the file can claim anything.
std::vector<std::int64_t> leaf_lengths(std::string_view metadata, const Topology& topology,
                                       const ValueCoding& coding, std::int64_t value_bytes);

}  // namespace psivox::vdb
