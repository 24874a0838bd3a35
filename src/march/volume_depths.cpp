#include "march/volume_depths.h"

#include <algorithm>
#include <array>
#include <glm/matrix.hpp>

#include "march/light_lattice.h"
#include "march/march_double.h"

namespace psivox {
namespace {

using BlockSums = std::array<float, 512>;

}  // namespace

VolumeDepths::VolumeDepths(const View& dark, const MediumAtlas* first,
                           const std::function<LightDepths(const View& alone)>& own) {
  const std::size_t count = 1 + dark.medium.others.size();
  volumes_.reserve(count);  // depths refer to them
  for (std::size_t i = 0; i < count; ++i) {
    Volume& volume = volumes_.emplace_back(Volume{seen_from(dark, i), {}});
    volume.alone.medium.others.clear();
    volume.alone.medium.emission.clear();
    if (!is_to_be_lit(dark, i)) continue;
    volume.atlas = i == 0 && first
                       ? std::shared_ptr<const MediumAtlas>(first, [](const MediumAtlas*) {})
                       : std::make_shared<const MediumAtlas>(build_medium_atlas(volume.alone));
    volume.own =
        i == 0 && own ? own(volume.alone) : march_double_light_depths(volume.alone, *volume.atlas);
  }
}

glm::dmat4 VolumeDepths::to_index(std::size_t from, std::size_t to) const {
  const auto world_from_index = [&](std::size_t volume) {
    return volumes_[volume].alone.medium.density->world_from_index;
  };
  if (world_from_index(from) == world_from_index(to)) return glm::dmat4(1);
  return glm::inverse(world_from_index(to)) * world_from_index(from);
}

void VolumeDepths::pass(std::size_t volume, std::size_t from, const Beam& beam, LightBlocks blocks,
                        const TakeDepths& add, const Progress& progress) const {
  const auto& [alone, atlas, own] = volumes_[volume];
  const glm::dmat4 placed = to_index(from, volume);
  if (beam.method.spacing > 0) {
    const LatticeFrame frame(alone, atlas->density.domain, beam);
    return lattice_depths(frame, *atlas, blocks, light_columns<double>(frame, alone, *atlas, beam),
                          add, progress, &placed);
  }
  const PointDepth depth = march_double_light_depth(alone, *atlas, beam);
  take_blocks(
      blocks,
      [&](const glm::ivec3& voxel) { return depth(glm::dvec3(placed * glm::dvec4(voxel, 1))); },
      add, progress);
}

LightDepths VolumeDepths::at(std::size_t volume) const {
  return one_by_one([this, volume](const Beam& beam, LightBlocks blocks, const TakeDepths& take,
                                   const Progress& progress) {
    const double share = 1 / double(volumes_.size());
    double passed = 0;
    // what other volumes hide, in the blocks that they do hide
    std::vector<std::unique_ptr<BlockSums>> hidden(blocks.size());
    const TakeDepths add = [&](std::size_t block, std::span<const double> depths) {
      if (std::ranges::all_of(depths, [](double depth) { return depth == 0; })) return;
      if (!hidden[block]) hidden[block] = std::make_unique<BlockSums>();
      std::ranges::transform(*hidden[block], depths, hidden[block]->begin(),
                             [](float sum, double depth) { return float(double(sum) + depth); });
    };
    for (std::size_t other = 0; other < volumes_.size(); ++other) {
      if (other == volume || !volumes_[other].atlas) continue;
      pass(other, volume, beam, blocks, add, part_of(progress, passed, share));
      passed += share;
    }
    const TakeLight take_all = [&](std::size_t, std::size_t block, std::span<const double> depths) {
      if (!hidden[block]) return take(block, depths);
      std::array<double, 512> sums;
      std::ranges::transform(depths, *hidden[block], sums.begin(),
                             [](double depth, float behind) { return depth + double(behind); });
      take(block, sums);
    };
    volumes_[volume].own({&beam, 1}, blocks, take_all, part_of(progress, passed, share));
  });
}

std::vector<double> VolumeDepths::exact(std::size_t volume, const Beam& beam,
                                        std::span<const glm::ivec3> voxels) const {
  std::vector<double> sums(voxels.size());
  for (std::size_t other = 0; other < volumes_.size(); ++other) {
    const Volume& through = volumes_[other];
    if (!through.atlas) continue;
    const glm::dmat4 placed = to_index(volume, other);
    const PointDepth depth = march_double_light_depth(through.alone, *through.atlas, beam);
    const std::vector<double> own = depths_of(voxels, [&](const glm::ivec3& voxel) {
      return depth(glm::dvec3(placed * glm::dvec4(voxel, 1)));
    });
    std::ranges::transform(sums, own, sums.begin(), std::plus());
  }
  return sums;
}

}  // namespace psivox
