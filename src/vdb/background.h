#pragma once

#include <openvdb/openvdb.h>

#include <optional>
#include <string>

#include "grid_check.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// The value that stands for the grid's background; unset: its own stays. Throws Error(input) if it
/// is not 0 under options.strict. `subject` begins the message.
std::optional<double> other_background(const openvdb::GridBase& grid, const GridSummary& summary,
                                       const ReadOptions& options, const std::string& subject);

/// What is then said, as the rest of a sentence.
std::string background_notice(const GridSummary& summary, const ReadOptions& options);

/// Gives `value` to inactive voxels, or tiles, of a node that have the value `old`. NaN is the same
/// as NaN.
template <typename NodeT, typename ValueT>
void replace_off(NodeT& node, const ValueT& old, const ValueT& value) {
  const auto same = [&](const ValueT& a) { return a == old || (!(a == a) && !(old == old)); };
  for (auto it = node.beginValueOff(); it; ++it)
    if (same(it.getValue())) it.setValue(value);
}

/// Gives `value` to all that has the grid's background: its inactive voxels and tiles, and, unless
/// the value is 0, the rest of the active voxels' box. The background becomes 0. Throws
/// std::runtime_error if the grid's type does not have the value, or the box is too large to fill.
void take_background(openvdb::GridBase& grid, const GridSummary& summary, double value);

/// Gives a level set whose file has the background 0, such as the surface of a liquid in Blender's
/// caches, the greatest of its distances as background. Class and values on both sides of 0 tell
/// that it is one; others stay as they are.
void complete_level_set(openvdb::GridBase& grid);

}  // namespace psivox::vdb
