#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "psivox/field.h"

// Values of a field whose leaves may stay in its file.

namespace psivox {

/// Bytes of the values of all leaves.
std::uint64_t value_bytes(const Field& field);

/// Throws Error(memory) if the values of leaves are not in memory, for what needs all of them.
void check_in_memory(const Field& field);

using VisitLeaves = std::function<void(std::span<const Leaf> leaves)>;
using WantLeaf = std::function<bool(const Leaf& leaf)>;

/// Visits the leaves with their values, in their order: all at once if they are in memory, else a
/// few thousand at a time. Those that are not wanted may be left out; by default all are wanted.
void visit_leaves(const Field& field, const VisitLeaves& visit, const WantLeaf& wanted = {});

/// The field with those leaves only that have voxels in the box, and their values in memory. It
/// keeps all tiles and everything else.
Field part_of_field(const Field& field, const Box& voxels);

}  // namespace psivox
