#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/matrix.hpp>
#include <mutex>
#include <numeric>

#include "draw/part_marcher.h"
#include "field/index_space.h"
#include "march/march_double.h"
#include "psivox/medium.h"
#include "reference/reference.h"

namespace psivox {
namespace {

/// Whether a ray from 0 meets a box.
bool meets(const glm::dvec3& min, const glm::dvec3& max, const glm::dvec3& direction) {
  const glm::dvec2 inside = interval_in(min, max, glm::dvec3(0), direction);
  return std::max(inside.x, 0.0) <= inside.y;
}

/// The wanted blocks from which rays towards the light meet a region, a box of bricks.
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

/// A block's depths towards a light as they are sent.
struct SentBlock {
  std::uint32_t number = 0;
  std::array<float, 512> depths{};
};

/// This member's depths towards blocks of another, without the blocks that its part does not hide.
std::vector<SentBlock> depths_towards(const LightDepths& own, const Beam& beam,
                                      std::span<const glm::ivec3> blocks,
                                      const Progress& progress) {
  std::vector<std::size_t> wanted(blocks.size());
  std::iota(wanted.begin(), wanted.end(), std::size_t{0});
  std::vector<SentBlock> found;
  std::mutex finding;
  const TakeLight take = [&](std::size_t, std::size_t block, std::span<const double> depths) {
    if (std::ranges::all_of(depths, [](double depth) { return depth == 0; })) return;
    const std::lock_guard lock(finding);
    found.push_back({std::uint32_t(block), {}});
    std::ranges::copy(depths, found.back().depths.begin());
  };
  own({&beam, 1}, {blocks, wanted}, take, progress);
  return found;
}

/// Sends a message to one member. Returns what another sends to this one.
template <typename T>
std::vector<T> pass_on(Team& team, std::vector<T> message, int to, int from) {
  std::vector<std::vector<T>> all(std::size_t(team.size()));
  all[std::size_t(to)] = std::move(message);
  return std::move(team.exchange(all)[std::size_t(from)]);
}

/// Optical depths through a volume of which each member has a part; `own` gives the depths through
/// this member's. Each computes them for the voxels that the others want and sends them, as
/// float32; they add up, in an order that only the number of members decides.
BeamDepths joined(Team& team, LightDepths own) {
  return [&team, own = std::move(own)](const Beam& beam, const LightBlocks& blocks,
                                       const TakeDepths& take, const Progress& progress) {
    std::vector<glm::ivec3> places;
    for (const std::size_t block : blocks.wanted) places.push_back(blocks.all[block]);
    std::vector<double> sums(512 * places.size());
    const int size = team.size(), rank = team.rank();
    // in each turn all work, each for another
    for (int turn = 0; turn < size; ++turn) {
      const int served = (rank + turn) % size, serving = (rank + size - turn) % size;
      const auto theirs = pass_on(team, places, serving, served);
      auto found = depths_towards(own, beam, theirs, [&](double done) {
        if (progress) progress((turn + done) / size);
      });
      for (const SentBlock& block : pass_on(team, std::move(found), served, serving))
        for (std::size_t i = 0; i < 512; ++i)
          sums[512 * std::size_t(block.number) + i] += double(block.depths[i]);
    }
    for (std::size_t i = 0; i < places.size(); ++i)
      take(blocks.wanted[i], std::span<const double>(sums).subspan(512 * i, 512));
  };
}

}  // namespace

LightDepths PartMarcher::light_depths(const View& view) {
  if (whole()) return marcher_.light_depths(view);
  return [this, &view](std::span<const Beam> beams, const LightBlocks& blocks,
                       const TakeLight& take, const Progress& progress) {
    const double all = double(beams.size());
    for (std::size_t first = 0, end = 0; first < beams.size(); first = end) {
      const bool exact = beams[first].method.spacing == 0;
      while (end < beams.size() && (beams[end].method.spacing == 0) == exact) ++end;
      const LightDepths depths = exact ? depths_by_rays(view) : depths_by_lattices(view);
      depths(
          beams.subspan(first, end - first), blocks,
          [&](std::size_t beam, std::size_t block, std::span<const double> own) {
            take(first + beam, block, own);
          },
          [&](double done) {
            if (progress) progress((double(first) + done * double(end - first)) / all);
          });
    }
  };
}

LightDepths PartMarcher::depths_by_rays(const View& view) {
  const LightDepths own = [this, &view](std::span<const Beam> beams, const LightBlocks& blocks,
                                        const TakeLight& take, const Progress& progress) {
    sum_rays(view, beams, blocks, take, progress);
  };
  return team_.size() == 1 ? own : one_by_one(joined(team_, own));
}

void PartMarcher::sum_rays(const View& view, std::span<const Beam> beams, const LightBlocks& blocks,
                           const TakeLight& take, const Progress& progress) {
  const std::vector<Region> regions = split_.own.all();
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

LightDepths PartMarcher::depths_by_lattices(const View& view) {
  if (team_.size() > 1)
    return one_by_one([this, &view](const Beam& beam, const LightBlocks& blocks,
                                    const TakeDepths& take, const Progress& progress) {
      exchanged_lattice(view, beam, blocks, take, progress);
    });
  return [this, &view](std::span<const Beam> beams, const LightBlocks& blocks,
                       const TakeLight& take, const Progress& progress) {
    const std::vector<glm::ivec3>& bricks = split_.own.bricks();
    // a layer is as large as a region, if they are one
    const std::size_t most = split_.own.count() == 1 ? bricks.size() : most_bricks();
    // the picture stores light beside each texel, on host and GPU; while light is computed,
    // lattices have one of the two
    const double bytes = double(most * brick_texels * sizeof(float));
    layered_depths(marcher_, view,
                   {bricks, most, bytes, [&](const Box& box) { upload_dark(view, box); }}, beams,
                   blocks, take, progress);
  };
}

void PartMarcher::exchanged_lattice(const View& view, const Beam& beam, const LightBlocks& blocks,
                                    const TakeDepths& take, const Progress& progress) {
  const std::vector<Region> regions = split_.own.all();
  const std::size_t most = std::ranges::max(team_.gather(regions.size()));
  std::vector<double> sums(most > 1 ? 512 * blocks.all.size() : 0);
  const TakeDepths add = [&](std::size_t block, std::span<const double> depths) {
    for (std::size_t i = 0; i < 512; ++i) sums[512 * block + i] += depths[i];
  };
  for (std::size_t region = 0; region < most; ++region) {
    const auto run = [&](const LatticeFrame& frame, const LatticeColumns& columns) {
      exchanged_depths(team_, frame, columns, blocks, most > 1 ? add : take, [&](double done) {
        if (progress) progress((double(region) + done) / double(most));
      });
    };
    if (region < regions.size()) {
      upload_dark(view, regions[region].bricks);
      marcher_.with_lattice(view, beam, run);
    } else {  // other members have more regions
      run(LatticeFrame(view, build_region_atlas(view, {}, {}, 0.0), beam),
          [](std::span<const LatticeBrick>, std::span<double> depths) {
            std::ranges::fill(depths, 0.0);
          });
    }
  }
  if (most > 1)
    for (const std::size_t block : blocks.wanted)
      take(block, std::span<const double>(sums).subspan(512 * block, 512));
}

LightPilot::Depths PartMarcher::exact_depths(const View& view, const MediumAtlas* atlas) {
  return [this, &view, atlas](const Beam& beam, std::span<const glm::ivec3> voxels) {
    if (atlas) return march_double_light_depths(view, *atlas, beam, voxels);
    if (team_.size() == 1) return reference_light_depths(view, beam, voxels);
    std::vector<double> sums(voxels.size());
    for (const Region& region : split_.own.all()) {
      upload_dark(view, region.bricks);
      const std::vector<double> depths = march_double_light_depths(view, dark_, beam, voxels);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += depths[i];
    }
    team_.sum(std::span(sums));
    return sums;
  };
}

LightShare PartMarcher::light_share(std::shared_ptr<const Field> density) const {
  const Box bricks = split_.parts.all()[std::size_t(team_.rank())].bricks;
  return {&team_, voxels_of(bricks), std::move(density)};
}

}  // namespace psivox
