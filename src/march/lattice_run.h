#pragma once

#include <memory>

#include "march/light_lattice.h"
#include "march/light_slabs.h"

namespace psivox {

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
