#include "draw/part_marcher.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "draw/strips.h"
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

}  // namespace

PartMarcher::PartMarcher(Marcher& marcher, Split split, Team& team)
    : marcher_(marcher), split_(std::move(split)), team_(team) {}

RenderResult PartMarcher::render(const View& view, const RenderOptions& options) {
  if (whole()) return marcher_.render(view, options);
  RenderResult result;
  RenderStats& stats = result.stats;
  const glm::ivec2& size = view.scene.resolution;
  const int samples = view.scene.pixel_samples;
  if (team_.size() == 1) {
    CarriedLight light(RayFold(view), {{}, size}, samples, options);
    carry(light, view, options, stats);
    result.image = light.picture(options.transmittance);
  } else {
    const Strips strips(team_, split_.parts, view);
    CarriedLight light(RayFold(view), strips.own_pixels(), samples);
    carry_together(light, view, options, stats);
    if (std::vector<float> depths = strips.ending(light); !depths.empty()) {
      light.begin_behind(std::move(depths));
      RenderOptions again = options;
      again.progress = {};
      team_.agree([&] { carry(light, view, again, stats); });
    }
    result.image = strips.picture(light, options.transmittance);
    add_up(team_, stats);
  }
  stats.rays = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(samples);
  return result;
}

void PartMarcher::carry(CarriedLight& light, const View& view, const RenderOptions& options,
                        RenderStats& stats) {
  give_back_freed_memory();
  drop_dark();
  View one = view;
  one.scene.pixel_samples = 1;
  const int samples = light.samples();
  const glm::ivec3 ghost = region_ghost(one);
  const double greatest = greatest_of(view);
  const auto regions = split_.own.front_to_back(view.camera, view.medium.density->world_from_index);
  RenderOptions part = options;
  part.transmittance = false;  // it is in the picture
  part.tile = {};
  double done = 0;
  const double share = 1.0 / double(regions.size() * std::size_t(samples));
  if (options.progress)
    part.progress = [&](double fraction) { options.progress(share * (done + fraction)); };
  const bool ends = light.fold().least_transmittance() > 0;
  stats.renderer = marcher_.description();
  for (const Region& region : regions) {
    const PixelBox seen = common(pixels_of(view, region.bricks), light.pixels());
    if (seen.empty() || light.ended(seen)) {
      done += samples;
      continue;
    }
    part.pixels = seen;
    const MediumAtlas atlas = build_region_atlas(view, region.bricks, ghost, greatest);
    marcher_.upload(atlas, view.scene.filter);
    for (int sample = 0; sample < samples; ++sample, ++done) {
      part.place = pixel_sample(sample, samples);
      if (part.depth || ends) part.passed = light.passed(seen, sample);
      const RenderResult drawn = marcher_.render(one, part);
      light.add(drawn.image, seen.origin, sample);
      add_counts(drawn.stats, stats);
    }
  }
  marcher_.holds = 0;
}

void PartMarcher::carry_together(CarriedLight& light, const View& view,
                                 const RenderOptions& options, RenderStats& stats) {
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
  team_.agree([&] {
    // also if it fails, for the first waits for it
    const struct Reporter {
      Team& team;
      ~Reporter() { team.report(1); }
    } reporter{team_};
    carry(light, view, mine, stats);
    if (!team_.first()) return;
    team_.report(1);
    for (Team::Reported all = team_.reported(); all.least < 1; all = team_.reported()) {
      if (options.progress) options.progress(all.mean);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  });
}

std::size_t PartMarcher::most_bricks() const {
  std::size_t most = 1;
  for (const Region& region : split_.own.all()) most = std::max(most, region.count);
  return most;
}

void PartMarcher::upload_dark(const View& view, const Box& bricks) {
  if (uploaded_ == bricks) return;
  drop_dark();  // not beside the next
  marcher_.holds = 0;
  View dark = view;
  dark.medium.luminance.reset();
  dark_ = build_region_atlas(dark, bricks, {}, greatest_of(view));
  marcher_.upload(dark_, Filter::exact);
  uploaded_ = bricks;
}

void PartMarcher::drop_dark() {
  uploaded_.reset();
  dark_ = {};
}

double PartMarcher::greatest_of(const View& view) {
  if (!greatest_) greatest_ = density_range(view.medium).y;
  return *greatest_;
}

}  // namespace psivox
