#pragma once

#include <functional>
#include <span>

#include "march/light_lattice.h"
#include "march/marcher.h"
#include "psivox/team.h"

// The lattices of lights through a volume of which a process holds one part at a time.

namespace psivox {

/// The parts of a volume that a lattice passes by: layers of bricks across the axis along which
/// light advances fastest.
struct PassingLayers {
  std::span<const glm::ivec3> bricks;             ///< of the volume
  std::size_t most = 0;                           ///< bricks that are uploaded at once
  double bytes = 0;                               ///< that the lattices of several lights may keep
  std::function<void(const Box& bricks)> upload;  ///< uploads a box of bricks for light
};

/// Depths towards beams with lattices. Each layer is uploaded once for as many lights as memory
/// allows, and each light's LatticeRun carries its columns from layer to layer. The depths of a
/// layer of several boxes add up.
void layered_depths(Marcher& marcher, const View& view, const PassingLayers& layers,
                    std::span<const Beam> beams, const LightBlocks& blocks, const TakeLight& take,
                    const Progress& progress);

/// Depths at this member's blocks, of what the atlases of all members hide. `frame` and `columns`
/// are those of this member's atlas. All members call it for the same beam. Some slabs at a time,
/// each computes the columns through its own atlas and sends the others what they need of them, as
/// float32; they add up in the order of ranks, and a LatticeRun carries them from the light on.
void exchanged_depths(Team& team, const LatticeFrame& frame, const LatticeColumns& columns,
                      const LightBlocks& blocks, const TakeDepths& take, const Progress& progress);

}  // namespace psivox
