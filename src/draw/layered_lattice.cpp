#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "atlas/regions.h"
#include "draw/part_marcher.h"
#include "march/lattice_tiles.h"

namespace psivox {
namespace {

/// Bricks between two planes across the axis of a light, and beside the first plane, on the light's
/// side, the layer that the first of their slices' steps begin in: as boxes [8 voxels, inclusive].
struct LightLayer {
  int first = 0, last = 0;  ///< along the axis
  std::vector<Box> boxes;   ///< one, unless a layer has too many bricks
};

/// Splits an axis into runs of slices of bricks. A run has at most `most` bricks or is one slice;
/// if `towards` is not 0, the slice beside it on the light's side counts too. Returns the first and
/// last slice of each run.
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
  std::ranges::copy_if(bricks, std::back_inserter(inside),
                       [&](const glm::ivec3& brick) { return box.contains(brick); });
  if (axes.empty() || inside.size() <= most) return boxes.push_back(box);
  const auto runs = runs_of(inside, axes.front(), most, 0);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Box part = box;
    if (i > 0) part.min[axes.front()] = runs[i].first;
    if (i + 1 < runs.size()) part.max[axes.front()] = runs[i + 1].first - 1;
    add_boxes(inside, part, axes.subspan(1), most, boxes);
  }
}

/// Layers in the order in which light meets them, so thick that a box has `most` bricks or a row.
std::vector<LightLayer> light_layers(std::span<const glm::ivec3> bricks, const LatticeFrame& frame,
                                     std::size_t most) {
  std::vector<LightLayer> layers;
  const std::array across{frame.axis_u, frame.axis_v};
  const auto runs = runs_of(bricks, frame.axis, most, frame.side);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Box box = everywhere;
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

/// The lattices of lights along one axis, from one side, on their way through the layers.
class LayeredRuns {
 public:
  LayeredRuns(Marcher& marcher, const View& view, std::span<const Beam> beams,
              std::span<const std::size_t> some, const LightBlocks& blocks, const TakeLight& take)
      : marcher_(marcher),
        view_(view),
        beams_(beams),
        some_(some),
        nothing_(build_region_atlas(view, {}, {}, 0.0)),
        frames_(frames_of(view, nothing_, beams, some)),
        slabs_(frames_.front(), blocks) {
    for (std::size_t i = 0; i < some.size(); ++i)
      runs_.emplace_back(
          frames_[i], slabs_, blocks,
          [&take, beam = some[i]](std::size_t block, std::span<const double> depths) {
            take(beam, block, depths);
          });
  }

  void pass(const PassingLayers& passing, const Progress& progress) {
    const std::vector<LightLayer> layers =
        light_layers(passing.bricks, frames_.front(), passing.most);
    for (std::size_t l = 0; l < layers.size(); ++l) {
      const LatticeFrame& frame = frames_.front();
      const int last = frame.side > 0 ? layers[l].first : layers[l].last;  // that light meets
      const int end = l + 1 == layers.size()
                          ? std::numeric_limits<int>::max()
                          : std::max(frame.slice(8 * last), frame.slice(8 * last + 7)) + 1;
      if (layers[l].boxes.size() == 1) passing.upload(layers[l].boxes.front());
      for (std::size_t i = 0; i < runs_.size(); ++i) {
        if (layers[l].boxes.size() == 1)
          through_box(i, end);
        else
          through_boxes(i, layers[l].boxes, end, passing);
        if (progress)
          progress((double(l) + double(i + 1) / double(runs_.size())) / double(layers.size()));
      }
      slabs_.drop_octants();
      begin_ = end;
    }
  }

 private:
  static std::vector<LatticeFrame> frames_of(const View& view, const MediumAtlas& nothing,
                                             std::span<const Beam> beams,
                                             std::span<const std::size_t> some) {
    std::vector<LatticeFrame> frames;
    for (const std::size_t b : some) frames.emplace_back(view, nothing, beams[b]).part.reset();
    return frames;
  }

  /// Through a layer that is uploaded.
  void through_box(std::size_t i, int end) {
    marcher_.with_lattice(view_, beams_[some_[i]],
                          [&](const LatticeFrame& own, const LatticeColumns& columns) {
                            if (i == 0)
                              slabs_.add_octants(frames_.front(), *own.density, begin_, end);
                            runs_[i].go_on(end, columns);
                          });
  }

  void through_boxes(std::size_t i, std::span<const Box> boxes, int end,
                     const PassingLayers& passing) {
    runs_[i].go_on(end, [&](std::span<const LatticeBrick> bricks, std::span<double> depths) {
      std::ranges::fill(depths, 0.0);
      std::vector<double> found(depths.size());
      for (const Box& box : boxes) {
        LatticeFrame part = frames_[i];
        part.set_part(box);
        if (std::ranges::none_of(bricks, [&](const auto& b) { return part.meets_part(b); }))
          continue;
        passing.upload(box);
        marcher_.with_lattice(view_, beams_[some_[i]],
                              [&](const LatticeFrame&, const LatticeColumns& columns) {
                                in_part(part, columns)(bricks, found);
                              });
        for (std::size_t n = 0; n < depths.size(); ++n) depths[n] += found[n];
      }
    });
  }

  Marcher& marcher_;
  const View& view_;
  std::span<const Beam> beams_;
  std::span<const std::size_t> some_;
  const MediumAtlas nothing_;
  std::vector<LatticeFrame> frames_;
  LightSlabs slabs_;
  std::vector<LatticeRun> runs_;
  int begin_ = std::numeric_limits<int>::min();
};

}  // namespace

void layered_depths(Marcher& marcher, const View& view, const PassingLayers& layers,
                    std::span<const Beam> beams, const LightBlocks& blocks, const TakeLight& take,
                    const Progress& progress) {
  const MediumAtlas nothing = build_region_atlas(view, {}, {}, 0.0);
  std::map<std::pair<int, int>, std::vector<std::size_t>> along;
  for (std::size_t b = 0; b < beams.size(); ++b) {
    const LatticeFrame frame(view, nothing, beams[b]);
    along[{frame.axis, frame.side}].push_back(b);
  }
  double done = 0;
  for (const auto& [way, some] : along)
    for (std::size_t first = 0, end = 0; first < some.size(); first = end) {
      double kept = 0;
      for (; end < some.size() && (end == first || kept < layers.bytes); ++end)
        kept += LatticeRun::bytes(LatticeFrame(view, nothing, beams[some[end]]));
      if (end - first > 1 && kept > layers.bytes) --end;
      const double share = double(end - first) / double(beams.size());
      LayeredRuns(marcher, view, beams, std::span(some).subspan(first, end - first), blocks, take)
          .pass(layers, [&](double fraction) {
            if (progress) progress(done + share * fraction);
          });
      done += share;
    }
}

}  // namespace psivox
