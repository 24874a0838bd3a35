#pragma once

#include <functional>
#include <span>
#include <vector>

#include "march/marcher.h"

namespace psivox {

/// Bricks between two planes across the axis of a light, and beside the first plane, on the light's
/// side, the layer that the first of their slices' steps begin in: as boxes [8 voxels, inclusive].
struct LightLayer {
  int first = 0, last = 0;  ///< along the axis
  std::vector<Box> boxes;   ///< one, unless a layer has too many bricks
};

/// Layers in the order in which light meets them, so thick that a box has `most` bricks or a row.
std::vector<LightLayer> light_layers(std::span<const glm::ivec3> bricks, const LatticeFrame& frame,
                                     std::size_t most);

/// Lattices of lights through a volume in parts. The volume passes by in layers across the axis
/// along which lights advance fastest, each uploaded once for as many lights as memory allows.
class RegionLattice {
 public:
  /// Uploads a box of bricks for light.
  using Upload = std::function<void(const Box& bricks)>;

  /// `most`: bricks that are uploaded at once. `bytes`: what lattices may keep.
  RegionLattice(Marcher& marcher, const View& view, std::span<const glm::ivec3> bricks,
                std::size_t most, double bytes, Upload upload)
      : marcher_(marcher),
        view_(view),
        bricks_(bricks),
        most_(most),
        bytes_(bytes),
        upload_(std::move(upload)) {}

  /// Depths towards beams with lattices.
  void depths(std::span<const Beam> beams, const LightBlocks& blocks, const TakeLight& take,
              const Progress& progress);

 private:
  /// Those of some beams along the same axis, from the same side.
  void pass(std::span<const Beam> beams, std::span<const std::size_t> some,
            const LightBlocks& blocks, const TakeLight& take, const Progress& progress);

  Marcher& marcher_;
  const View& view_;
  std::span<const glm::ivec3> bricks_;
  std::size_t most_;
  double bytes_;
  Upload upload_;
};

}  // namespace psivox
