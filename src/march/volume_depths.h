#pragma once

#include <vector>

#include "march/light.h"
#include "march/medium_atlas.h"

namespace psivox {

/// Optical depths towards light through all volumes of a medium, from voxels of each. They are the
/// sums of the depths through each volume alone, by rays or by the columns of its own lattice.
class VolumeDepths {
 public:
  /// `dark`: its light is still to be computed. `first`: its first volume's atlas, which must
  /// outlive the depths; null: one is built. `own`: depths through the first volume alone from its
  /// own voxels; unset: they are marched in double.
  explicit VolumeDepths(const View& dark, const MediumAtlas* first = nullptr,
                        const std::function<LightDepths(const View& alone)>& own = {});

  /// From the voxels of a volume; 0: the first. These depths must not outlive the object.
  LightDepths at(std::size_t volume) const;

  /// The atlas of a volume, which attenuates something.
  const MediumAtlas& atlas(std::size_t volume) const { return *volumes_[volume].atlas; }

  /// Exact depths from some voxels of a volume.
  std::vector<double> exact(std::size_t volume, const Beam& beam,
                            std::span<const glm::ivec3> voxels) const;

 private:
  struct Volume {
    View alone;
    std::shared_ptr<const MediumAtlas> atlas;  ///< null: nothing attenuates
    LightDepths own{};
  };

  glm::dmat4 to_index(std::size_t from, std::size_t to) const;
  /// Adds the depths through a volume from the wanted blocks of another.
  void pass(std::size_t volume, std::size_t from, const Beam& beam, LightBlocks blocks,
            const TakeDepths& add, const Progress& progress) const;

  std::vector<Volume> volumes_;
};

}  // namespace psivox
