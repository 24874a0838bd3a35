#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "grid_file.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// Statistics that add up.
struct Statistics {
  double least = std::numeric_limits<double>::infinity(), greatest = -least, mean = 0, voxels = 0;
  std::uint64_t not_finite = 0;

  void add(double value, std::uint64_t count);
  void add(const Statistics& other);
  std::optional<ValueStatistics> all() const;  ///< unset: no value was finite
};

/// Sets the world's box by the active box and the transform, which must be affine.
void set_world_box(GridInfo& info);

/// The row of one grid; reads its tree, without `values` only its topology. Never throws for a bad
/// grid: GridInfo::problem says why.
GridInfo grid_info(GridFile& file, const GridEntry& entry, bool values);

/// What a picture could be made of. It reads the topology, and leaves up to the first that has an
/// active value other than 0. Throws Error(input).
GridContent content_of(GridFile& file, const GridEntry& entry);

/// What a picture could be made of a grid with so many active voxels, some of which are not 0.
GridContent content_of(std::uint64_t active_voxels, bool has_value);

}  // namespace psivox::vdb
