#include "march/light.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "ray_radiance.h"

namespace psivox {

LightDepths reference_light_depths(const View& view) {
  return [&view](const Beam& beam, const LightBlocks& blocks, const TakeDepths& take,
                 const Progress& progress) {
    const RayMedium medium(light_march(view, beam).medium);
    tbb::enumerable_thread_specific<RayIntegrator> workers(
        [&] { return RayIntegrator(medium, 1e-12); });
    const glm::dmat4& world_from_index = medium.medium.density->world_from_index;
    in_batches(blocks, progress, [&](std::span<const std::size_t> some) {
      tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
        RayIntegrator& integrator = workers.local();
        std::vector<double> depths(512);
        for (int i = 0; i < 512; ++i) {
          const glm::ivec3 voxel = blocks.all[some[k]] + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
          const glm::dvec3 at(world_from_index * glm::dvec4(voxel, 1));
          depths[std::size_t(i)] = integrator.optical_depth({at, -beam.direction});
        }
        take(some[k], depths);
      });
    });
  };
}

}  // namespace psivox
