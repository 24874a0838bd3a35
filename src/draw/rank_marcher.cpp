#include "draw/rank_marcher.h"

#include "draw/rank_lattice.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

namespace psivox {
namespace {

/// The rows that a rank folds.
PixelBox strip_of(const glm::ivec2& size, int rank, int count) {
  const auto row = [&](int n) { return int(std::int64_t(size.y) * n / count); };
  return {{0, row(rank)}, {size.x, row(rank + 1) - row(rank)}};
}

template <typename Number>
std::vector<Number> numbers_of(const std::string& bytes) {
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(Number));
  return numbers;
}

template <typename Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

}  // namespace

RankMarcher::RankMarcher(Marcher& marcher, Team& team, const Regions& parts, const Regions& own)
    : own_(marcher, own), team_(team), parts_(parts) {
  for (const std::string& count : team.gather(std::to_string(own.count())))
    most_regions_ = std::max<std::size_t>(most_regions_, std::stoul(count));
}

LightDepths RankMarcher::light_depths(const View& view) {
  return one_by_one([this, &view, by_rays = joined_depths(team_, own_.light_depths(view))](
                        const Beam& beam, const LightBlocks& blocks, const TakeDepths& take,
                        const Progress& progress) {
    if (beam.method.spacing == 0)
      by_rays(beam, blocks, take, progress);
    else
      lattice(view, beam, blocks, take, progress);
  });
}

void RankMarcher::lattice(const View& view, const Beam& beam, const LightBlocks& blocks,
                          const TakeDepths& take, const Progress& progress) {
  const glm::ivec3 ghost = region_ghost(view);
  std::vector<Box> bricks;
  for (const Region& part : parts_.all())
    bricks.push_back({part.bricks.min - ghost, part.bricks.max + ghost});
  RankLattice lattice(team_, std::move(bricks));
  std::vector<double> sums(most_regions_ > 1 ? 512 * blocks.all.size() : 0);
  const TakeDepths add = [&](std::size_t block, std::span<const double> depths) {
    for (std::size_t i = 0; i < 512; ++i) sums[512 * block + i] += depths[i];
  };
  for (std::size_t region = 0; region < most_regions_; ++region)
    own_.with_lattice_of(
        region, view, beam, [&](const LatticeFrame& frame, const LatticeColumns& columns) {
          lattice.depths(frame, columns, blocks, most_regions_ > 1 ? add : take, [&](double done) {
            if (progress) progress((double(region) + done) / double(most_regions_));
          });
        });
  if (most_regions_ > 1)
    for (const std::size_t block : blocks.wanted)
      take(block, std::span<const double>(sums).subspan(512 * block, 512));
}

LightShare RankMarcher::light_share(const std::shared_ptr<const Field>& whole) {
  constexpr glm::ivec3 most(1 << 27);  // the outermost parts reach farther than there are voxels
  const Box bricks = parts_.all()[std::size_t(team_.rank())].bricks;
  return {{8 * glm::max(bricks.min, -most), 8 * glm::min(bricks.max, most) + 7},
          whole,
          [this](const std::string& bytes) { return team_.gather(bytes); }};
}

LightPilot::Depths RankMarcher::exact_depths(const View& view) {
  return [this, &view](const Beam& beam, std::span<const glm::ivec3> voxels) {
    std::vector<double> sums(voxels.size());
    for (const std::string& found : team_.gather(bytes_of(own_.exact_depths(view, beam, voxels)))) {
      const auto depths = numbers_of<double>(found);
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += depths[i];
    }
    return sums;
  };
}

CarriedLight RankMarcher::carry_own(const View& view, const RenderOptions& options,
                                    const PixelBox& pixels, RenderStats& stats) {
  using std::chrono::steady_clock;
  RenderOptions mine = options;
  auto reported = steady_clock::now();
  mine.progress = [&](double fraction) {
    constexpr std::chrono::milliseconds pause(200);
    if (fraction >= 1 || steady_clock::now() - reported < pause) return;
    reported = steady_clock::now();
    team_.report(fraction);
    if (team_.first() && options.progress) options.progress(team_.reported().mean);
  };
  CarriedLight light(RayFold(view), pixels, view.scene.pixel_samples);
  team_.agree([&] {
    // also if it fails, for the first rank waits for it
    const struct Reporter {
      Team& team;
      ~Reporter() { team.report(1); }
    } reporter{team_};
    light = own_.carry(view, mine, pixels, stats);
    if (!team_.first()) return;
    team_.report(1);
    for (Team::Reported all = team_.reported(); all.least < 1; all = team_.reported()) {
      if (options.progress) options.progress(all.mean);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
  return light;
}

CarriedLight RankMarcher::fold(const View& view, const CarriedLight& own,
                               const std::vector<PixelBox>& seen) {
  const int count = team_.size(), samples = own.samples();
  const glm::ivec2 size = view.scene.resolution;
  const PixelBox strip = strip_of(size, team_.rank(), count);
  const auto order = parts_.front_to_back(view.camera, view.medium.density->world_from_index);
  CarriedLight light(RayFold(view), strip, samples);
  for (int sample = 0; sample < samples; ++sample) {
    std::vector<std::vector<glm::vec4>> sent(std::size_t(count), std::vector<glm::vec4>{});
    for (int rank = 0; rank < count; ++rank) {
      const PixelBox box = common(own.pixels(), strip_of(size, rank, count));
      for (int y = 0; y < box.size.y; ++y)
        for (const glm::dvec4& ray : own.row(box.origin + glm::ivec2(0, y), box.size.x, sample))
          sent[std::size_t(rank)].emplace_back(ray);
    }
    const auto received = team_.exchange(sent);
    for (const Region& part : order) {
      const PixelBox box = common(seen[part.number], strip);
      std::span<const glm::vec4> rows = received[part.number];
      for (int y = 0; y < box.size.y; ++y, rows = rows.subspan(std::size_t(box.size.x)))
        light.add(rows.first(std::size_t(box.size.x)), box.origin + glm::ivec2(0, y), sample);
    }
  }
  return light;
}

Image RankMarcher::collect(const Image& strip, const glm::ivec2& size) {
  Image picture;
  for (const Layer& layer : strip.layers) {
    const auto strips = team_.collect(layer.values);
    if (!team_.first()) continue;
    picture.layers.push_back({layer.name, layer.channels, {}});
    std::vector<float>& values = picture.layers.back().values;
    values.reserve(std::size_t(size.x) * std::size_t(size.y) * layer.channels.size());
    for (const auto& part : strips) values.insert(values.end(), part.begin(), part.end());
  }
  if (team_.first()) {
    picture.width = size.x;
    picture.height = size.y;
  }
  return picture;
}

/// Counts of all ranks, and the times of the slowest.
void RankMarcher::add_up(RenderStats& stats) {
  struct Numbers {
    std::uint64_t samples, steps, stuck;
    double shader_ms, upload_ms, march_ms, gpu_ms, cpu_ms;
  };
  const Numbers own{stats.samples,   stats.steps,    stats.stuck,  stats.shader_ms,
                    stats.upload_ms, stats.march_ms, stats.gpu_ms, stats.cpu_ms};
  std::string bytes(sizeof own, '\0');
  std::memcpy(bytes.data(), &own, sizeof own);
  stats.samples = stats.steps = stats.stuck = 0;
  stats.cpu_ms = 0;
  for (const std::string& others : team_.gather(bytes)) {
    Numbers n;
    std::memcpy(&n, others.data(), sizeof n);
    stats.samples += n.samples;
    stats.steps += n.steps;
    stats.stuck += n.stuck;
    stats.shader_ms = std::max(stats.shader_ms, n.shader_ms);
    stats.upload_ms = std::max(stats.upload_ms, n.upload_ms);
    stats.march_ms = std::max(stats.march_ms, n.march_ms);
    stats.gpu_ms = std::max(stats.gpu_ms, n.gpu_ms);
    stats.cpu_ms += n.cpu_ms;
  }
}

RenderResult RankMarcher::render(const View& view, const RenderOptions& options) {
  std::vector<PixelBox> seen;
  for (const Region& part : parts_.all())
    seen.push_back(part.empty() ? PixelBox{} : pixels_of(view, part.bricks));
  const PixelBox& own = seen[std::size_t(team_.rank())];
  RenderResult result;
  const CarriedLight light = carry_own(view, options, own, result.stats);
  const glm::ivec2 size = view.scene.resolution;
  result.image = collect(fold(view, light, seen).picture(options.transmittance), size);
  add_up(result.stats);
  result.stats.rays =
      std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(view.scene.pixel_samples);
  return result;
}

}  // namespace psivox
