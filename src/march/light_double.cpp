#include <tbb/parallel_for.h>

#include "march/atlas_march.h"
#include "march/light.h"
#include "march/light_lattice.h"
#include "march/march_double.h"

namespace psivox {
namespace {

double light_depth(glsl::AtlasMarch& march, const glm::ivec3& voxel) {
  const auto ray = march.light_ray(voxel);
  auto state = march.begin_march(ray);
  march_on(march, state, ray);
  return state.optical_depth;
}

void exact_depths(const View& view, const MediumAtlas& atlas, const Beam& beam,
                  const LightBlocks& blocks, const TakeDepths& take, const Progress& progress) {
  const MarchSetup setup = make_march_setup(light_march(view, beam), atlas);
  in_batches(blocks, progress, [&](std::span<const std::size_t> some) {
    tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
      glsl::AtlasMarch march(setup, atlas);
      std::vector<double> depths(512);
      const glm::ivec3 first = blocks.all[some[k]] - setup.origin;
      for (int i = 0; i < 512; ++i)
        depths[std::size_t(i)] =
            light_depth(march, first + glm::ivec3(i >> 6, (i >> 3) & 7, i & 7));
      take(some[k], depths);
    });
  });
}

}  // namespace

void DoubleMarcher::with_lattice(const View& view, const Beam& beam, const UseLattice& use) {
  const LatticeFrame frame(view, *atlas_, beam);
  use(frame, light_columns<double>(frame, view, *atlas_, beam));
}

LightDepths march_double_light_depths(const View& view, const MediumAtlas& atlas) {
  return one_by_one([&](const Beam& beam, const LightBlocks& blocks, const TakeDepths& take,
                        const Progress& progress) {
    if (beam.method.spacing == 0) return exact_depths(view, atlas, beam, blocks, take, progress);
    const LatticeFrame frame(view, atlas, beam);
    lattice_depths(frame, blocks, light_columns<double>(frame, view, atlas, beam), take, progress);
  });
}

std::vector<double> march_double_light_depths(const View& view, const MediumAtlas& atlas,
                                              const Beam& beam,
                                              std::span<const glm::ivec3> voxels) {
  const MarchSetup setup = make_march_setup(light_march(view, beam), atlas);
  std::vector<double> depths(voxels.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, voxels.size(), 64), [&](const auto& some) {
    glsl::AtlasMarch march(setup, atlas);
    for (std::size_t i = some.begin(); i != some.end(); ++i)
      depths[i] = light_depth(march, voxels[i] - setup.origin);
  });
  return depths;
}

}  // namespace psivox
