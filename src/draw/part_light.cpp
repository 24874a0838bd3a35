#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/matrix.hpp>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>

#include "draw/part_marcher.h"
#include "field/index_space.h"
#include "march/light_lattice.h"
#include "march/march_double.h"
#include "psivox/medium.h"
#include "reference/reference.h"

namespace psivox {
namespace in_parts {

/// Whether a ray from 0 meets a box.
bool meets(const glm::dvec3& min, const glm::dvec3& max, const glm::dvec3& direction) {
  const glm::dvec2 inside = interval_in(min, max, glm::dvec3(0), direction);
  return std::max(inside.x, 0.0) <= inside.y;
}

/// The numbers of the blocks from which rays towards the light meet a region, a box of bricks.
std::vector<std::size_t> behind(const Box& region, LightBlocks blocks, const glm::dvec3& towards) {
  // its cells reach a voxel beyond its bricks
  const glm::dvec3 min = 8.0 * glm::dvec3(region.min) - 1.0;
  const glm::dvec3 max = 8.0 * (glm::dvec3(region.max) + 1.0) + 1.0;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const glm::dvec3 first(blocks[i]);
    // the differences between a point of the region and a voxel of the block
    if (meets(min - (first + 7.0), max - first, towards)) some.push_back(i);
  }
  return some;
}

/// A block's depths towards a light as they are sent.
struct SentBlock {
  std::uint32_t number = 0;
  std::array<float, 512> depths{};
};

/// Adds it to a member's messages, unless all depths are 0. Several threads call it.
class Outbox {
 public:
  explicit Outbox(int members) : messages_(std::size_t(members)) {}

  void add(std::size_t to, std::size_t number, std::span<const double> depths) {
    if (std::ranges::all_of(depths, [](double depth) { return depth == 0; })) return;
    const std::lock_guard lock(adding_);
    std::ranges::copy(
        depths, messages_[to].emplace_back(SentBlock{std::uint32_t(number), {}}).depths.begin());
  }
  /// Sends all. Returns what each member sends to this one.
  std::vector<std::vector<SentBlock>> exchange(Team& team) {
    auto received = team.exchange(messages_);
    for (auto& message : messages_) message.clear();
    return received;
  }

 private:
  std::mutex adding_;
  std::vector<std::vector<SentBlock>> messages_;
};

/// A layer of bricks across a light's axis: slabs up to `last`, and the bricks on whose faces the
/// first slab's steps begin. One box, unless a slab has too many bricks.
struct LightLayer {
  int last = 0;
  std::vector<Region> boxes;
};

/// The layer that begins with a slab, as thick as `most` bricks allow.
LightLayer layer_from(int slab, std::span<const glm::ivec3> bricks, const Box& part,
                      const LatticeFrame& frame, std::size_t most) {
  std::map<int, std::size_t> counts;  // by slab
  for (const glm::ivec3& brick : bricks) ++counts[frame.slab(8 * brick)];
  const auto count = [&](int k) { return counts.contains(k) ? counts.at(k) : 0; };
  LightLayer layer{slab, {}};
  std::size_t sum = count(slab - 1) + count(slab);
  while (layer.last + 1 < frame.slabs()) {
    sum += count(layer.last + 1);
    if (sum > most) break;
    ++layer.last;
  }
  std::vector<glm::ivec3> inside;
  Box box = part;
  const auto brick_of = [&](int k) {
    return frame.side > 0 ? (frame.first - 8 * k - 7) / 8 : frame.first / 8 + k;
  };
  const auto [low, high] = std::minmax({brick_of(slab - 1), brick_of(layer.last)});
  box.min[frame.axis] = std::max(box.min[frame.axis], low);
  box.max[frame.axis] = std::min(box.max[frame.axis], high);
  std::ranges::copy_if(bricks, std::back_inserter(inside),
                       [&](const glm::ivec3& brick) { return box.contains(brick); });
  layer.boxes = Regions(std::move(inside), layer.last > slab ? bricks.size() : most, box).all();
  return layer;
}

}  // namespace in_parts

/// The lattices of lights along one axis, from one side, on their way through all parts of a
/// volume. Each layer of this member's bricks is uploaded once, and what it hides of the blocks of
/// all members is sent, some slabs at a time, as float32. The depths add up in the order of ranks.
/// A team passes one beam at a time.
class PartMarcher::Lattices {
 public:
  Lattices(PartMarcher& parts, const View& view, std::span<const Beam> beams,
           std::span<const LatticeFrame> frames, LightBlocks blocks, TakeLight take)
      : parts_(parts),
        view_(view),
        beams_(beams),
        frames_(frames),
        own_(blocks),
        take_(std::move(take)),
        outbox_(parts.team_.size()) {
    for (const auto& places : parts.team_.gather(std::vector(blocks.begin(), blocks.end()))) {
      firsts_.push_back(places_.size());
      places_.insert(places_.end(), places.begin(), places.end());
    }
    for (std::size_t beam = 0; beam < beams.size(); ++beam)
      runs_.emplace_back(frames[beam], places_,
                         [this, beam](std::size_t block, std::span<const double> depths) {
                           give(beam, block, depths);
                         });
  }

  void pass(const Progress& progress) {
    const LatticeFrame& frame = frames_.front();
    const int slabs = frame.slabs();
    const Box part = is_alone() ? everywhere : parts_.own_part();
    in_parts::LightLayer layer{-1, {}};
    for (int slab = 0; slab < slabs; ++slab) {
      if (slab > layer.last)
        layer = in_parts::layer_from(slab, parts_.split_.own.bricks(), part, frame,
                                     parts_.layer_bricks());
      for (const Region& box : layer.boxes) {
        show(box.bricks);
        for (std::size_t i = 0; i < runs_.size(); ++i) {
          runs_[i].add(slab, *dark_, columns_[i]);
          if (&box == &layer.boxes.back()) runs_[i].finish(slab);
        }
      }
      if (!is_alone() && (slab % slabs_at_once == slabs_at_once - 1 || slab + 1 == slabs))
        join(slab - slab % slabs_at_once, slab);
      if (progress) progress(double(slab + 1) / double(slabs));
    }
  }

 private:
  /// Slabs whose depths are sent at once.
  static constexpr int slabs_at_once = 4;

  /// Makes some bricks those that light passes.
  void show(const Box& bricks) {
    if (shown_ == bricks) return;
    parts_.upload_dark(view_, bricks);
    dark_.emplace(frames_.front(), parts_.dark_);
    columns_.clear();
    for (std::size_t i = 0; i < runs_.size(); ++i)
      columns_.push_back(parts_.marcher_.light_columns(frames_[i], view_, beams_[i]));
    shown_ = bricks;
  }

  void give(std::size_t beam, std::size_t block, std::span<const double> depths) {
    if (is_alone()) return take_(beam, block, depths);
    const auto member = std::upper_bound(firsts_.begin(), firsts_.end(), block) - firsts_.begin();
    const auto rank = std::size_t(member - 1);
    outbox_.add(rank, block - firsts_[rank], depths);
  }

  /// Adds up what all members' parts hide of this one's blocks in some slabs, for the only beam.
  void join(int first, int last) {
    std::map<std::size_t, std::array<double, 512>> sums;
    for (std::size_t i = 0; i < own_.size(); ++i)
      if (const int slab = frames_.front().slab(own_[i]); slab >= first && slab <= last)
        sums[i] = {};
    for (const auto& message : outbox_.exchange(parts_.team_))
      for (const auto& sent : message)
        std::ranges::transform(sums.at(sent.number), sent.depths, sums.at(sent.number).begin(),
                               [](double sum, float depth) { return sum + double(depth); });
    for (const auto& [block, depths] : sums) take_(0, block, depths);
  }

  bool is_alone() const { return parts_.team_.size() == 1; }

  PartMarcher& parts_;
  const View& view_;
  std::span<const Beam> beams_;
  std::span<const LatticeFrame> frames_;
  LightBlocks own_;
  TakeLight take_;
  in_parts::Outbox outbox_;
  std::vector<glm::ivec3> places_;   ///< blocks of all members
  std::vector<std::size_t> firsts_;  ///< of each member
  std::vector<LatticeRun> runs_;
  std::optional<Box> shown_;
  std::optional<DarkCells> dark_;
  std::vector<LatticeColumns> columns_;
};

LightDepths PartMarcher::light_depths(const View& view) {
  if (whole()) return marcher_.light_depths(view);
  return [this, &view](std::span<const Beam> beams, LightBlocks blocks, const TakeLight& take,
                       const Progress& progress) {
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
          part_of(progress, double(first) / all, double(end - first) / all));
    }
  };
}

LightDepths PartMarcher::depths_by_rays(const View& view) {
  return one_by_one([this, &view](const Beam& beam, LightBlocks blocks, const TakeDepths& take,
                                  const Progress& progress) {
    // sums of depths take no more than a region's texels
    const auto members = std::size_t(team_.size());
    const std::size_t at_once = std::max<std::size_t>(most_bricks() / members, 256);
    const std::size_t chunks =
        std::ranges::max(team_.gather((blocks.size() + at_once - 1) / at_once));
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      const std::size_t first = std::min(chunk * at_once, blocks.size());
      const LightBlocks own = blocks.subspan(first, std::min(at_once, blocks.size() - first));
      std::vector<glm::ivec3> places;  // of all members
      std::vector<std::vector<float>> messages(members);
      for (std::size_t rank = 0;
           const auto& some : team_.gather(std::vector(own.begin(), own.end()))) {
        places.insert(places.end(), some.begin(), some.end());
        messages[rank++].resize(512 * some.size());
      }
      std::vector<double> sums =
          sum_rays(view, beam, places,
                   part_of(progress, double(chunk) / double(chunks), 1 / double(chunks)));
      if (members > 1) {
        const double* from = sums.data();
        for (std::vector<float>& message : messages)
          for (float& depth : message) depth = float(*from++);
        sums.assign(512 * own.size(), 0.0);
        for (const std::vector<float>& message : team_.exchange(messages))
          for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += double(message[i]);
      }
      for (std::size_t i = 0; i < own.size(); ++i)
        take(first + i, std::span<const double>(sums).subspan(512 * i, 512));
    }
  });
}

std::vector<double> PartMarcher::sum_rays(const View& view, const Beam& beam, LightBlocks blocks,
                                          const Progress& progress) {
  const glm::dvec3 towards =
      glm::inverse(glm::dmat3(view.medium.density->world_from_index)) * -beam.direction;
  const std::vector<Region> regions = split_.own.all();
  std::vector<double> sums(512 * blocks.size());
  for (std::size_t done = 0; const Region& region : regions) {
    const std::vector<std::size_t> numbers = in_parts::behind(region.bricks, blocks, towards);
    std::vector<glm::ivec3> behind_it;
    for (const std::size_t number : numbers) behind_it.push_back(blocks[number]);
    const TakeLight add = [&](std::size_t, std::size_t block, std::span<const double> depths) {
      double* sum = sums.data() + 512 * numbers[block];
      for (std::size_t i = 0; i < depths.size(); ++i) sum[i] += depths[i];
    };
    if (!behind_it.empty()) {
      upload_dark(view, region.bricks);
      const double share = 1 / double(regions.size());
      marcher_.light_depths(view)({&beam, 1}, behind_it, add,
                                  part_of(progress, share * double(done), share));
    }
    ++done;
  }
  return sums;
}

std::size_t PartMarcher::layer_bricks() const {
  return split_.own.count() == 1 ? split_.own.bricks().size() : most_bricks();
}

LightDepths PartMarcher::depths_by_lattices(const View& view) {
  return [this, &view](std::span<const Beam> beams, LightBlocks blocks, const TakeLight& take,
                       const Progress& progress) {
    // The picture stores light beside each texel, on host and GPU. While light is computed,
    // lattices have one of the two; those of a team go one by one.
    const double bytes =
        team_.size() > 1 ? 0 : double(layer_bricks() * brick_texels * sizeof(float));
    const Box domain = build_region_atlas(view, {}).density.domain;
    std::map<std::pair<int, int>, std::vector<std::size_t>> along;
    for (std::size_t b = 0; b < beams.size(); ++b) {
      const LatticeFrame frame(view, domain, beams[b]);
      along[{frame.axis, frame.side}].push_back(b);
    }
    double done = 0;
    for (const auto& [way, numbers] : along)
      for (std::size_t next = 0; next < numbers.size();) {
        std::vector<std::size_t> some;
        std::vector<Beam> group;
        std::vector<LatticeFrame> frames;
        for (double kept = 0; next < numbers.size(); ++next) {
          const LatticeFrame frame(view, domain, beams[numbers[next]]);
          kept += LatticeRun::bytes(frame);
          if (!some.empty() && kept > bytes) break;
          some.push_back(numbers[next]);
          group.push_back(beams[numbers[next]]);
          frames.push_back(frame);
        }
        const double share = double(some.size()) / double(beams.size());
        Lattices(*this, view, group, frames, blocks,
                 [&](std::size_t beam, std::size_t block, std::span<const double> depths) {
                   take(some[beam], block, depths);
                 })
            .pass(part_of(progress, done, share));
        done += share;
      }
  };
}

std::vector<double> PartMarcher::exact_depths(const View& view, const Beam& beam,
                                              std::span<const glm::ivec3> voxels) {
  if (team_.size() == 1) return reference_light_depths(view, beam, voxels);
  std::vector<double> sums(voxels.size());
  for (const Region& region : split_.own.all()) {
    upload_dark(view, region.bricks);
    const std::vector<double> depths = march_double_light_depths(view, dark_, beam, voxels);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += depths[i];
  }
  team_.sum(std::span(sums));
  return sums;
}

std::vector<std::vector<Crossed>> PartMarcher::crossed(const View& view,
                                                       std::span<const glm::dvec2> places) {
  struct Sent {
    std::uint32_t ray;
    Crossed cell;
  };
  std::vector<Sent> own;
  for (const Region& region : split_.own.all()) {
    upload_dark(view, region.bricks);
    const auto cells = crossed_cells(view, dark_, places);
    for (std::size_t ray = 0; ray < cells.size(); ++ray)
      for (const Crossed& cell : cells[ray]) own.push_back({std::uint32_t(ray), cell});
  }
  std::vector<std::vector<Crossed>> all(places.size());
  for (const auto& some : team_.gather(own))
    for (const Sent& sent : some) all[sent.ray].push_back(sent.cell);
  for (std::vector<Crossed>& ray : all) std::ranges::sort(ray, std::less{}, &Crossed::front);
  return all;
}

LightSource PartMarcher::light_source(const MediumAtlas* whole) {
  return {[this](const View& view) { return light_depths(view); },
          [this, whole](const View& view) -> ExactDepths {
            return [this, &view, whole](const Beam& beam, std::span<const glm::ivec3> voxels) {
              return whole ? march_double_light_depths(view, *whole, beam, voxels)
                           : exact_depths(view, beam, voxels);
            };
          },
          [this, whole](const View& view, std::span<const glm::dvec2> places) {
            return whole ? crossed_cells(view, *whole, places) : crossed(view, places);
          },
          whole,
          {&team_, voxels_of(own_part())}};
}

}  // namespace psivox
