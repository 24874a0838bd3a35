#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <memory>

#include "march/atlas_march.h"
#include "march/light.h"

namespace psivox {

LightDepths march_double_light_depths(const View& view, const MediumAtlas& atlas) {
  const auto setup = std::make_shared<const MarchSetup>(make_march_setup(light_march(view), atlas));
  return [setup, &atlas](std::span<const glm::ivec3> origins) {
    std::vector<double> depths(origins.size() * 512);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size()),
                      [&](const tbb::blocked_range<std::size_t>& blocks) {
                        glsl::AtlasMarch march(*setup, atlas);
                        for (std::size_t b = blocks.begin(); b != blocks.end(); ++b)
                          for (int i = 0; i < 512; ++i)
                            depths[b * 512 + std::size_t(i)] =
                                march.light_depth(origins[b] - setup->origin +
                                                  glm::ivec3(i >> 6, (i >> 3) & 7, i & 7));
                      });
    return depths;
  };
}

}  // namespace psivox
