#include "draw/region_marcher.h"

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>

#include "draw/region_lattice.h"
#include "draw/trial_method.h"
#include "march/light_lattice.h"
#include "march/march_double.h"
#include "psivox/parts.h"

namespace psivox {
namespace {

void add_counts(const RenderStats& part, RenderStats& sum) {
  sum.renderer = part.renderer;
  sum.samples += part.samples;
  sum.steps += part.steps;
  sum.stuck += part.stuck;
  sum.passes = std::max(sum.passes, part.passes);
  for (double RenderStats::*time :
       {&RenderStats::gl_init_ms, &RenderStats::shader_ms, &RenderStats::upload_ms,
        &RenderStats::march_ms, &RenderStats::gpu_ms, &RenderStats::cpu_ms})
    sum.*time += part.*time;
}

/// Whether a ray from 0 meets a box.
bool meets(const glm::dvec3& min, const glm::dvec3& max, const glm::dvec3& direction) {
  double enter = 0, leave = INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    if (d == 0 && (min[axis] > 0 || max[axis] < 0)) return false;
    if (d == 0) continue;
    enter = std::max(enter, (d > 0 ? min : max)[axis] / d);
    leave = std::min(leave, (d > 0 ? max : min)[axis] / d);
  }
  return enter <= leave;
}

/// Those of the wanted blocks from which rays towards the light meet a region, a box of bricks.
std::vector<std::size_t> behind(const Box& region, const LightBlocks& blocks,
                                const glm::dvec3& towards) {
  // its cells reach a voxel beyond its bricks
  const glm::dvec3 min = 8.0 * glm::dvec3(region.min) - 1.0;
  const glm::dvec3 max = 8.0 * (glm::dvec3(region.max) + 1.0) + 1.0;
  std::vector<std::size_t> some;
  for (const std::size_t block : blocks.wanted) {
    const glm::dvec3 first(blocks.all[block]);
    // the differences between a point of the region and a voxel of the block
    if (meets(min - (first + 7.0), max - first, towards)) some.push_back(block);
  }
  return some;
}

}  // namespace

LightDepths RegionMarcher::light_depths(const View& view) {
  return [this, &view](std::span<const Beam> beams, const LightBlocks& blocks,
                       const TakeLight& take, const Progress& progress) {
    give_back_freed_memory();
    std::vector<Beam> rays, lattices;
    std::vector<std::size_t> of_rays, of_lattices;  // their numbers
    for (std::size_t b = 0; b < beams.size(); ++b) {
      const bool exact = beams[b].method.spacing == 0;
      (exact ? rays : lattices).push_back(beams[b]);
      (exact ? of_rays : of_lattices).push_back(b);
    }
    const double share = double(rays.size()) / double(beams.size());
    const auto numbered = [&take](const std::vector<std::size_t>& numbers) -> TakeLight {
      return [&](std::size_t beam, std::size_t block, std::span<const double> depths) {
        take(numbers[beam], block, depths);
      };
    };
    if (!rays.empty())
      by_rays(view, rays, blocks, numbered(of_rays), [&](double done) {
        if (progress) progress(share * done);
      });
    if (!lattices.empty())
      by_lattices(view, lattices, blocks, numbered(of_lattices), [&](double done) {
        if (progress) progress(share + (1 - share) * done);
      });
  };
}

std::size_t RegionMarcher::most_bricks() const {
  std::size_t most = 1;
  for (const Region& region : regions_.all()) most = std::max(most, region.count);
  return most;
}

void RegionMarcher::by_lattices(const View& view, std::span<const Beam> beams,
                                const LightBlocks& blocks, const TakeLight& take,
                                const Progress& progress) {
  const std::vector<glm::ivec3>& bricks = regions_.bricks();
  // a layer is as large as a region, if they are one
  const std::size_t most = regions_.count() == 1 ? bricks.size() : most_bricks();
  // the picture stores light beside each texel, on host and GPU; while light is computed, lattices
  // have one of the two
  const double bytes = double(most * brick_texels * sizeof(float));
  RegionLattice(marcher_, view, bricks, most, bytes, [&](const Box& box) {
    upload_dark(view, box);
  }).depths(beams, blocks, take, progress);
}

void RegionMarcher::by_rays(const View& view, std::span<const Beam> beams,
                            const LightBlocks& blocks, const TakeLight& take,
                            const Progress& progress) {
  const std::vector<Region> regions = regions_.all();
  // sums of depths take no more than a region's texels
  const std::size_t at_once = std::max<std::size_t>(most_bricks(), 256);
  std::vector<std::size_t> rows(blocks.all.size());
  std::vector<double> sums;
  double done = 0;
  for (const Beam& beam : beams) {
    const glm::dvec3 towards =
        glm::inverse(glm::dmat3(view.medium.density->world_from_index)) * -beam.direction;
    for (std::size_t first = 0; first < blocks.wanted.size(); first += at_once) {
      const LightBlocks some{
          blocks.all,
          blocks.wanted.subspan(first, std::min(at_once, blocks.wanted.size() - first))};
      sums.assign(512 * some.wanted.size(), 0.0);
      for (std::size_t i = 0; i < some.wanted.size(); ++i) rows[some.wanted[i]] = 512 * i;
      const TakeLight add = [&](std::size_t, std::size_t block, std::span<const double> depths) {
        double* sum = sums.data() + rows[block];
        for (std::size_t i = 0; i < depths.size(); ++i) sum[i] += depths[i];
      };
      const double share =
          double(some.wanted.size()) / double(blocks.wanted.size() * beams.size() * regions.size());
      for (const Region& region : regions) {
        const std::vector<std::size_t> behind_it = behind(region.bricks, some, towards);
        if (!behind_it.empty()) {
          upload_dark(view, region.bricks);
          marcher_.light_depths(view)({&beam, 1}, {blocks.all, behind_it}, add, [&](double part) {
            if (progress) progress(done + share * part);
          });
        }
        done += share;
      }
      const auto number = std::size_t(&beam - beams.data());
      for (const std::size_t block : some.wanted)
        take(number, block, std::span<const double>(sums).subspan(rows[block], 512));
    }
  }
}

void RegionMarcher::with_lattice_of(std::size_t region, const View& view, const Beam& beam,
                                    const UseLattice& use) {
  if (region < regions()) {
    upload_dark(view, regions_.all()[region].bricks);
    return marcher_.with_lattice(view, beam, use);
  }
  const MediumAtlas nothing = build_region_atlas(view, {}, {}, 0.0);
  use(LatticeFrame(view, nothing, beam),
      [](std::span<const LatticeBrick>, std::span<double> depths) {
        std::ranges::fill(depths, 0.0);
      });
}

std::vector<double> RegionMarcher::exact_depths(const View& view, const Beam& beam,
                                                std::span<const glm::ivec3> voxels) {
  std::vector<double> sums(voxels.size());
  for (const Region& region : regions_.all()) {
    upload_dark(view, region.bricks);
    const std::vector<double> depths = march_double_light_depths(view, dark_, beam, voxels);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += depths[i];
  }
  return sums;
}

void RegionMarcher::upload_dark(const View& view, const Box& bricks) {
  if (uploaded_ == bricks) return;
  uploaded_.reset();
  dark_ = {};  // not beside the next
  marcher_.holds = 0;
  View dark = view;
  dark.medium.luminance.reset();
  dark_ = build_region_atlas(dark, bricks, {}, greatest_of(view));
  marcher_.upload(dark_, Filter::exact);
  uploaded_ = bricks;
}

double RegionMarcher::greatest_of(const View& view) {
  if (!greatest_) greatest_ = density_range(view.medium).y;
  return *greatest_;
}

CarriedLight RegionMarcher::carry(const View& view, const RenderOptions& options,
                                  const PixelBox& pixels, RenderStats& stats) {
  give_back_freed_memory();
  dark_ = {};
  uploaded_.reset();
  View one = view.scene.tolerance ? with_method(view, exact_method(view)) : view;
  one.scene.pixel_samples = 1;
  const int samples = view.scene.pixel_samples;
  const glm::ivec3 ghost = region_ghost(one);
  const double greatest = greatest_of(view);
  const auto regions = regions_.front_to_back(view.camera, view.medium.density->world_from_index);
  RenderOptions part = options;
  part.transmittance = false;  // it is in the picture
  part.tile = {};
  double done = 0;
  const double share = 1.0 / double(regions.size() * std::size_t(samples));
  if (options.progress)
    part.progress = [&](double fraction) { options.progress(share * (done + fraction)); };
  CarriedLight light(RayFold(one), pixels, samples, options);
  stats.renderer = marcher_.description();
  for (const Region& region : regions) {
    const PixelBox seen = pixels_of(view, region.bricks);
    if (seen.empty() || light.ended(seen, one.scene.resolved_early_termination())) {
      done += samples;
      continue;
    }
    part.pixels = seen;
    const MediumAtlas atlas = build_region_atlas(view, region.bricks, ghost, greatest);
    marcher_.upload(atlas, view.scene.filter);
    for (int sample = 0; sample < samples; ++sample, ++done) {
      part.place = pixel_sample(sample, samples);
      if (part.depth) part.passed = light.passed(seen, sample);
      const RenderResult drawn = marcher_.render(one, part);
      light.add(drawn.image, seen.origin, sample);
      add_counts(drawn.stats, stats);
    }
  }
  marcher_.holds = 0;
  stats.rays = std::uint64_t(pixels.size.x) * std::uint64_t(pixels.size.y) * std::uint64_t(samples);
  return light;
}

RenderResult RegionMarcher::render(const View& view, const RenderOptions& options) {
  RenderResult result;
  const CarriedLight light = carry(view, options, {{}, view.scene.resolution}, result.stats);
  result.image = light.picture(options.transmittance);
  return result;
}

}  // namespace psivox
