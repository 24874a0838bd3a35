#pragma once

#include <cstdint>
#include <memory>
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

/// The lattice of one light on its way through the slabs. It keeps the depths at which its columns
/// have come to a slab, and the depths inside a slab of a few rows of tiles at a time, whatever the
/// volume's size.
class LatticeRun {
 public:
  /// Without `take` it asks for the columns alone. Slabs and blocks must outlive it.
  LatticeRun(const LatticeFrame& frame, const LightSlabs& slabs, const LightBlocks& blocks,
             TakeDepths take);
  ~LatticeRun();
  LatticeRun(LatticeRun&&) noexcept;

  /// Goes on through the slabs whose first slice is below `end`. Columns are asked for in their
  /// order.
  void go_on(int end, const LatticeColumns& columns, const Progress& progress = {});

  /// About what it keeps between slabs [bytes].
  static double bytes(const LatticeFrame& frame);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Columns which ask for those bricks alone that meet the frame's part, if it has one.
LatticeColumns in_part(const LatticeFrame& frame, const LatticeColumns& columns);

}  // namespace psivox
