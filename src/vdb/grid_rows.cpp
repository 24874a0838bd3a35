#include "grid_rows.h"

#include <cstdlib>

namespace psivox::vdb {

void Statistics::add(double value, std::uint64_t count) {
  if (!std::isfinite(value)) {
    not_finite += count;
    return;
  }
  least = std::min(least, value);
  greatest = std::max(greatest, value);
  voxels += static_cast<double>(count);
  mean += (value - mean) * static_cast<double>(count) / voxels;
}

void Statistics::add(const Statistics& other) {
  not_finite += other.not_finite;
  if (other.voxels == 0) return;
  least = std::min(least, other.least);
  greatest = std::max(greatest, other.greatest);
  voxels += other.voxels;
  mean += (other.mean - mean) * other.voxels / voxels;
}

std::optional<ValueStatistics> Statistics::all() const {
  if (voxels == 0) return std::nullopt;
  return ValueStatistics{least, greatest, mean, not_finite};
}

GridContent content_of(std::uint64_t active_voxels, bool has_value) {
  return {active_voxels, has_value            ? ""
                         : active_voxels == 0 ? "has no active voxel"
                                              : "is 0 everywhere"};
}

constexpr std::int64_t max_extent = std::int64_t{1} << 30;
bool too_large(const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t lo = box.min[axis], hi = box.max[axis];
    if (hi - lo + 1 >= max_extent || std::abs(lo) >= max_extent || std::abs(hi) >= max_extent) {
      return true;
    }
  }
  return false;
}

}  // namespace psivox::vdb
