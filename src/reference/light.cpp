#include "march/light.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <memory>

#include "ray_radiance.h"

namespace psivox {

LightDepths reference_light_depths(const View& view) {
  const auto medium = std::make_shared<const RayMedium>(light_march(view).medium);
  const glm::dvec3 towards = -view.medium.light->direction;
  return [medium, towards](std::span<const glm::ivec3> origins) {
    std::vector<double> depths(origins.size() * 512);
    tbb::enumerable_thread_specific<RayIntegrator> workers(
        [&] { return RayIntegrator(*medium, 1e-12); });
    const glm::dmat4& world_from_index = medium->medium.density->world_from_index;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size()), [&](const tbb::
                                                                                  blocked_range<
                                                                                      std::size_t>&
                                                                                      blocks) {
      RayIntegrator& integrator = workers.local();
      for (std::size_t b = blocks.begin(); b != blocks.end(); ++b)
        for (int i = 0; i < 512; ++i) {
          const glm::ivec3 voxel = origins[b] + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7);
          const glm::dvec3 at(world_from_index * glm::dvec4(voxel, 1));
          depths[b * 512 + static_cast<std::size_t>(i)] = integrator.optical_depth({at, towards});
        }
    });
    return depths;
  };
}

}  // namespace psivox
