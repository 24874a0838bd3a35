#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "ray_radiance.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Optical depths from voxels towards a beam.
class VoxelDepths {
 public:
  VoxelDepths(const View& view, const Beam& beam)
      : medium_(light_march(view, beam).medium), towards_(-beam.direction) {}

  double operator()(const glm::ivec3& voxel) {
    const glm::dmat4& world_from_index = medium_.medium.density->world_from_index;
    const glm::dvec3 at(world_from_index * glm::dvec4(voxel, 1));
    return workers_.local().optical_depth({at, towards_});
  }

 private:
  RayMedium medium_;
  glm::dvec3 towards_;
  tbb::enumerable_thread_specific<RayIntegrator> workers_{
      [this] { return RayIntegrator(medium_, 1e-12); }};
};

}  // namespace

LightDepths reference_light_depths(const View& view) {
  return one_by_one([&view](const Beam& beam, const LightBlocks& blocks, const TakeDepths& take,
                            const Progress& progress) {
    VoxelDepths depth(view, beam);
    in_batches(blocks, progress, [&](std::span<const std::size_t> some) {
      tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
        std::vector<double> depths(512);
        for (int i = 0; i < 512; ++i)
          depths[std::size_t(i)] =
              depth(blocks.all[some[k]] + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7));
        take(some[k], depths);
      });
    });
  });
}

std::vector<double> reference_light_depths(const View& view, const Beam& beam,
                                           std::span<const glm::ivec3> voxels) {
  VoxelDepths depth(view, beam);
  std::vector<double> depths(voxels.size());
  tbb::parallel_for(std::size_t{0}, voxels.size(),
                    [&](std::size_t i) { depths[i] = depth(voxels[i]); });
  return depths;
}

}  // namespace psivox
