#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psivox {

/// Active voxels of one value, outside leaves.
struct TileValue {
  float value = 0;
  std::uint64_t voxels = 0;
};

/// Which values of a file's grid are active; what a LeafReader may be, too.
class ActiveValues {
 public:
  virtual ~ActiveValues() = default;
  /// As LeafReader::read, with NaN in the first channel of voxels that are not active. Throws
  /// Error(input).
  virtual void read_active(std::span<const std::uint32_t> leaves, float* values) const = 0;
  /// Active tiles, those of 0 too.
  virtual const std::vector<TileValue>& active_tiles() const = 0;
};

}  // namespace psivox
