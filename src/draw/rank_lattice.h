#pragma once

#include <utility>
#include <vector>

#include "march/light_lattice.h"
#include "psivox/team.h"

namespace psivox {

/// The lattice of a light through a volume of which each of several processes holds a part. Each
/// computes the columns through its own part, slab by slab in the order in which light meets them,
/// and sends the others what they need: where a column comes to a rank's bricks the depth up to
/// there, and beside the rank's part the depths within them. All are float32 and add up in the
/// order of ranks.
class RankLattice {
 public:
  /// `bricks`: those whose light each rank asks for.
  RankLattice(Team& team, std::vector<Box> bricks) : team_(team), bricks_(std::move(bricks)) {}

  /// Depths at the blocks' voxels, of what all ranks' atlases hide. `frame` and `columns` are those
  /// of this rank's. All must call it for the same beam.
  void depths(const LatticeFrame& frame, const LatticeColumns& columns, const LightBlocks& blocks,
              const TakeDepths& take, const Progress& progress);

 private:
  Team& team_;
  std::vector<Box> bricks_;
};

}  // namespace psivox
