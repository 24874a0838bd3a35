#include "draw/region_lattice.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "march/lattice_run.h"
#include "psivox/regions.h"

namespace psivox {
namespace {

/// Planes that part an axis into runs of slices of bricks, each run as long as it has no more than
/// `most` bricks in it and in the slice beside it, on the light's side if `towards` is not 0. First
/// and last slice of each run.
std::vector<std::pair<int, int>> runs_of(std::span<const glm::ivec3> bricks, int axis,
                                         std::size_t most, int towards) {
  std::map<int, std::size_t> counts;
  for (const glm::ivec3& brick : bricks) ++counts[brick[axis]];
  if (counts.empty()) return {{0, 0}};
  // a step behind the last brick begins in it
  if (towards < 0) counts.try_emplace(counts.rbegin()->first + 1, 0);
  const auto beside = [&](int slice) {
    const auto found = counts.find(slice + towards);
    return towards != 0 && found != counts.end() ? found->second : 0;
  };
  std::vector<std::pair<int, int>> runs;
  std::size_t sum = 0;
  for (const auto& [slice, count] : counts) {
    const std::size_t below = towards < 0 && !runs.empty() ? beside(runs.back().first) : 0;
    const std::size_t above = towards > 0 ? beside(slice) : 0;
    if (runs.empty() || sum + count + below + above > most) {
      if (!runs.empty()) runs.back().second = slice - 1;
      runs.emplace_back(slice, slice);
      sum = 0;
    }
    runs.back().second = slice;
    sum += count;
  }
  return runs;
}

/// Boxes of no more bricks than `most`, or of one row, that fill a box.
void add_boxes(std::span<const glm::ivec3> bricks, const Box& box, std::span<const int> axes,
               std::size_t most, std::vector<Box>& boxes) {
  std::vector<glm::ivec3> inside;
  std::ranges::copy_if(bricks, std::back_inserter(inside), [&](const glm::ivec3& brick) {
    return glm::clamp(brick, box.min, box.max) == brick;
  });
  if (axes.empty() || inside.size() <= most) return boxes.push_back(box);
  const auto runs = runs_of(inside, axes.front(), most, 0);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Box part = box;
    if (i > 0) part.min[axes.front()] = runs[i].first;
    if (i + 1 < runs.size()) part.max[axes.front()] = runs[i + 1].first - 1;
    add_boxes(inside, part, axes.subspan(1), most, boxes);
  }
}

}  // namespace

std::vector<LightLayer> light_layers(std::span<const glm::ivec3> bricks, const LatticeFrame& frame,
                                     std::size_t most) {
  std::vector<LightLayer> layers;
  const std::array across{frame.axis_u, frame.axis_v};
  const auto runs = runs_of(bricks, frame.axis, most, frame.side);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Box box = Regions::everywhere();
    int& low = box.min[frame.axis];
    int& high = box.max[frame.axis];
    LightLayer layer{
        i == 0 ? low : runs[i].first, i + 1 == runs.size() ? high : runs[i].second, {}};
    low = layer.first - (i > 0 && frame.side < 0);
    high = layer.last + (i + 1 < runs.size() && frame.side > 0);
    add_boxes(bricks, box, across, most, layer.boxes);
    layers.push_back(std::move(layer));
  }
  if (frame.side > 0) std::ranges::reverse(layers);
  return layers;
}

void RegionLattice::depths(std::span<const Beam> beams, const LightBlocks& blocks,
                           const TakeLight& take, const Progress& progress) {
  const MediumAtlas nothing = build_region_atlas(view_, {}, {}, 0.0);
  std::map<std::pair<int, int>, std::vector<std::size_t>> along;
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const LatticeFrame frame(view_, nothing, beams[b]);
    along[{frame.axis, frame.side}].push_back(b);
  }
  double done = 0;
  for (const auto& [way, some] : along)
    for (std::size_t first = 0, end = 0; first < some.size(); first = end) {
      double kept = 0;
      for (; end < some.size() && (end == first || kept < bytes_); ++end)
        kept += LatticeRun::bytes(LatticeFrame(view_, nothing, beams[some[end]]));
      if (end - first > 1 && kept > bytes_) --end;
      const double share = double(end - first) / double(beams.size());
      pass(beams, std::span(some).subspan(first, end - first), blocks, take, [&](double fraction) {
        if (progress) progress(done + share * fraction);
      });
      done += share;
    }
}

void RegionLattice::pass(std::span<const Beam> beams, std::span<const std::size_t> some,
                         const LightBlocks& blocks, const TakeLight& take,
                         const Progress& progress) {
  const MediumAtlas nothing = build_region_atlas(view_, {}, {}, 0.0);
  std::vector<LatticeFrame> frames;
  for (const std::size_t b : some) frames.emplace_back(view_, nothing, beams[b]);
  for (LatticeFrame& frame : frames) frame.part.reset();
  const LatticeFrame& frame = frames.front();
  LightSlabs slabs(frame, blocks);
  std::vector<LatticeRun> runs;
  for (std::size_t i = 0; i < some.size(); ++i)
    runs.emplace_back(frames[i], slabs, blocks,
                      [&take, beam = some[i]](std::size_t block, std::span<const double> depths) {
                        take(beam, block, depths);
                      });
  const std::vector<LightLayer> layers = light_layers(bricks_, frame, most_);
  int begin = std::numeric_limits<int>::min();
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const LightLayer& layer = layers[l];
    const int last = frame.side > 0 ? layer.first : layer.last;  // that light meets
    const int end = l + 1 == layers.size()
                        ? std::numeric_limits<int>::max()
                        : std::max(frame.slice(8 * last), frame.slice(8 * last + 7)) + 1;
    const auto through = [&](const auto& go_on) {
      for (std::size_t i = 0; i < runs.size(); ++i) {
        go_on(i);
        if (progress)
          progress((double(l) + double(i + 1) / double(runs.size())) / double(layers.size()));
      }
    };
    if (layer.boxes.size() == 1) {
      upload_(layer.boxes.front());
      bool known = false;
      through([&](std::size_t i) {
        marcher_.with_lattice(view_, beams[some[i]],
                              [&](const LatticeFrame& own, const LatticeColumns& columns) {
                                if (!known) slabs.add_octants(frame, *own.density, begin, end);
                                known = true;
                                runs[i].go_on(end, columns);
                              });
      });
    } else {
      through([&](std::size_t i) {
        runs[i].go_on(end, [&](std::span<const LatticeBrick> bricks, std::span<double> depths) {
          std::ranges::fill(depths, 0.0);
          std::vector<double> found(depths.size());
          for (const Box& box : layer.boxes) {
            LatticeFrame part = frames[i];
            part.set_part(box);
            if (std::ranges::none_of(bricks, [&](const auto& b) { return part.meets_part(b); }))
              continue;
            upload_(box);
            marcher_.with_lattice(view_, beams[some[i]],
                                  [&](const LatticeFrame&, const LatticeColumns& columns) {
                                    in_part(part, columns)(bricks, found);
                                  });
            for (std::size_t n = 0; n < depths.size(); ++n) depths[n] += found[n];
          }
        });
      });
    }
    slabs.drop_octants();
    begin = end;
  }
}

}  // namespace psivox
