// Optical depths towards light, of voxels and of blocks; and those of the march in double.
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <functional>
#include <glm/common.hpp>
#include <memory>

#include "field/field_cursor.h"
#include "field/leaf_values.h"
#include "march/atlas_march.h"
#include "march/light.h"
#include "march/light_lattice.h"
#include "march/march_double.h"

namespace psivox {
namespace {

/// Blocks whose exact depths are asked for at once, between two reports of progress.
constexpr std::size_t batch = 512;

/// Optical depths towards a beam, by rays.
class MarchedDepths {
 public:
  MarchedDepths(const View& view, const MediumAtlas& atlas, const Beam& beam)
      : setup_(make_march_setup(light_march(view, beam), atlas)), atlas_(atlas) {}

  double operator()(const glm::dvec3& point) {
    glsl::AtlasMarch& march = workers_.local();
    const auto ray = ray_from(march, point);
    if (!(ray.end > ray.begin)) return 0;
    auto state = march.begin_march(ray);
    march_on(march, state, ray);
    return state.optical_depth;
  }

 private:
  glsl::AtlasMarch::Ray ray_from(glsl::AtlasMarch& march, const glm::dvec3& point) const {
    const auto& grid = march.density;
    const Box& domain = atlas_.density.domain;
    if (glm::clamp(point, glm::dvec3(domain.min), glm::dvec3(domain.max)) == point)
      if (const glm::ivec3 voxel = nearest_voxel(point); glm::dvec3(voxel) == point)
        return march.light_ray(voxel - setup_.origin);
    const glm::dvec3 at = point - glm::dvec3(setup_.origin) + (march.nearest ? 0.5 : 0.0);
    return march.make_ray(at, grid.direction_0, grid.domain_min, grid.domain_max, 0.0);
  }

  MarchSetup setup_;
  const MediumAtlas& atlas_;
  tbb::enumerable_thread_specific<glsl::AtlasMarch> workers_{
      [this] { return glsl::AtlasMarch(setup_, atlas_); }};
};

}  // namespace

Progress part_of(const Progress& progress, double begin, double size) {
  if (!progress) return {};
  return [&progress, begin, size](double done) { progress(begin + size * done); };
}

LightDepths one_by_one(BeamDepths depths) {
  return [depths = std::move(depths)](std::span<const Beam> beams, LightBlocks blocks,
                                      const TakeLight& take, const Progress& progress) {
    const double share = 1 / double(beams.size());
    for (std::size_t b = 0; b < beams.size(); ++b)
      depths(
          beams[b], blocks,
          [&](std::size_t block, std::span<const double> part) { take(b, block, part); },
          part_of(progress, share * double(b), share));
  };
}

void in_batches(LightBlocks blocks, const Progress& progress,
                const std::function<void(std::size_t first, std::size_t end)>& some) {
  for (std::size_t first = 0; first < blocks.size(); first += batch) {
    const std::size_t end = std::min(blocks.size(), first + batch);
    some(first, end);
    if (progress) progress(double(end) / double(blocks.size()));
  }
}

void take_blocks(LightBlocks blocks, const VoxelDepth& depth, const TakeDepths& take,
                 const Progress& progress) {
  in_batches(blocks, progress, [&](std::size_t first, std::size_t end) {
    tbb::parallel_for(first, end, [&](std::size_t block) {
      std::array<double, 512> depths;
      for (int i = 0; i < 512; ++i) depths[std::size_t(i)] = depth(blocks[block] + leaf_voxel(i));
      take(block, depths);
    });
  });
}

std::vector<double> depths_of(std::span<const glm::ivec3> voxels, const VoxelDepth& depth) {
  std::vector<double> depths(voxels.size());
  tbb::parallel_for(std::size_t{0}, voxels.size(),
                    [&](std::size_t i) { depths[i] = depth(voxels[i]); });
  return depths;
}

LatticeColumns DoubleMarcher::light_columns(const LatticeFrame& frame, const View& view,
                                            const Beam& beam) {
  return psivox::light_columns<double>(frame, view, *atlas_, beam);
}

PointDepth march_double_light_depth(const View& view, const MediumAtlas& atlas, const Beam& beam) {
  return [depths = std::make_shared<MarchedDepths>(view, atlas, beam)](const glm::dvec3& point) {
    return (*depths)(point);
  };
}

LightDepths march_double_light_depths(const View& view, const MediumAtlas& atlas) {
  return one_by_one(
      [&](const Beam& beam, LightBlocks blocks, const TakeDepths& take, const Progress& progress) {
        if (beam.method.spacing == 0)
          return take_blocks(blocks, march_double_light_depth(view, atlas, beam), take, progress);
        const LatticeFrame frame(view, atlas.density.domain, beam);
        lattice_depths(frame, atlas, blocks, light_columns<double>(frame, view, atlas, beam), take,
                       progress);
      });
}

std::vector<double> march_double_light_depths(const View& view, const MediumAtlas& atlas,
                                              const Beam& beam,
                                              std::span<const glm::ivec3> voxels) {
  return depths_of(voxels, march_double_light_depth(view, atlas, beam));
}

}  // namespace psivox
