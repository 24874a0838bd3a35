#pragma once

#include <cstdint>
#include <vector>

#include "march/light_lattice.h"

namespace psivox {

/// 4^3 cells with attenuation: their first corner, and the first slice that they reach.
struct Octant {
  glm::ivec3 corner;
  int slice;
};

/// The blocks of 8 slices.
struct LightSlab {
  int first_slice = 0;
  std::vector<std::uint32_t> blocks, wanted;  ///< their places among all, wanted ones along axis_u
  std::vector<Octant> octants;                ///< with attenuation; empty: not known
};

/// Blocks by slabs, in the order in which light meets them. All lights along the same axis from the
/// same side have the same.
class LightSlabs {
 public:
  LightSlabs(const LatticeFrame& frame, const LightBlocks& blocks);

  const std::vector<LightSlab>& all() const { return slabs_; }
  /// Adds the octants of an atlas to the slabs whose first slice is in [begin, end).
  void add_octants(const LatticeFrame& frame, const BrickAtlas& density, int begin, int end);
  /// Forgets them.
  void drop_octants();

 private:
  std::vector<LightSlab> slabs_;
};

}  // namespace psivox
