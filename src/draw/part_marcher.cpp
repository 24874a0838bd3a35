#include "draw/part_marcher.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "psivox/medium.h"

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

/// Joins what the members of a team have collected in their parts. Each folds one strip of rows: it
/// gets from every member the light that the strip's rays carry through that member's part, and
/// joins it in the order of parts, front to back. Then the first collects the strips.
class Strips {
 public:
  /// `parts`: one for each member.
  Strips(Team& team, const Regions& parts, const View& view);

  /// The pixels that see this member's part.
  const PixelBox& own_pixels() const { return seen_[std::size_t(team_.rank())]; }

  /// Which of this member's rays end in its part, in the whole picture, although they would not end
  /// there by this part alone: the optical depth that each has passed before, by its index, and
  /// CarriedLight::no_ray for all others. Unset: no member has one.
  std::optional<std::vector<float>> ending(const CarriedLight& own) const;

  /// The picture, in the first.
  Image picture(const CarriedLight& own, bool transmittance) const;

 private:
  /// Has each member send `of(ray)` for its rays of a sample to their strips. Calls
  /// `each(part, first pixel, numbers)` for rows of this member's strip, part by part, front to
  /// back.
  template <typename Number, typename Of, typename Each>
  void join(const CarriedLight& own, int sample, const Of& of, const Each& each) const;
  PixelBox strip_of(int rank) const;

  Team& team_;
  const View& view_;
  std::vector<Region> order_;   ///< parts, front to back
  std::vector<PixelBox> seen_;  ///< pixels, by part
};

Strips::Strips(Team& team, const Regions& parts, const View& view)
    : team_(team),
      view_(view),
      order_(parts.front_to_back(view.camera, view.medium.density->world_from_index)) {
  for (const Region& part : parts.all())
    seen_.push_back(part.empty() ? PixelBox{} : pixels_of(view, part.bricks));
}

PixelBox Strips::strip_of(int rank) const {
  const glm::ivec2& size = view_.scene.resolution;
  const auto row = [&](int n) { return int(std::int64_t(size.y) * n / team_.size()); };
  return {{0, row(rank)}, {size.x, row(rank + 1) - row(rank)}};
}

/// Calls `each` with the first pixel of each row of a rectangle.
template <typename Each>
void for_rows(const PixelBox& box, const Each& each) {
  for (int y = 0; y < box.size.y; ++y) each(box.origin + glm::ivec2(0, y));
}

template <typename Number, typename Of, typename Each>
void Strips::join(const CarriedLight& own, int sample, const Of& of, const Each& each) const {
  std::vector<std::vector<Number>> sent(std::size_t(team_.size()));
  for (int rank = 0; rank < team_.size(); ++rank) {
    const PixelBox box = common(own.pixels(), strip_of(rank));
    for_rows(box, [&](const glm::ivec2& first) {
      for (const glm::dvec4& ray : own.row(first, box.size.x, sample))
        sent[std::size_t(rank)].push_back(of(ray));
    });
  }
  const auto received = team_.exchange(sent);
  for (const Region& part : order_) {
    const PixelBox box = common(seen_[part.number], strip_of(team_.rank()));
    std::span<const Number> left = received[part.number];
    for_rows(box, [&](const glm::ivec2& first) {
      each(part.number, first, left.first(std::size_t(box.size.x)));
      left = left.subspan(std::size_t(box.size.x));
    });
  }
}

std::optional<std::vector<float>> Strips::ending(const CarriedLight& own) const {
  const RayFold& fold = own.fold();
  const double least = fold.least_transmittance();
  if (!(least > 0)) return {};
  std::vector<float> depths(own.rays());
  std::uint64_t found = 0;
  for (int sample = 0; sample < own.samples(); ++sample) {
    std::vector<std::vector<float>> answers(std::size_t(team_.size()));
    CarriedLight front(fold, strip_of(team_.rank()), 1);
    join<float>(
        own, sample, [&](const glm::dvec4& ray) { return float(fold.transmittance(ray)); },
        [&](std::size_t part, const glm::ivec2& first, std::span<const float> through) {
          std::vector<glm::vec4> row;
          const auto rays = front.row(first, int(through.size()), 0);
          for (std::size_t i = 0; i < rays.size(); ++i) {
            const double before = rays[i].a;
            row.emplace_back(0, 0, 0, through[i]);
            const bool ends = before < 1 && before > least && before * double(through[i]) <= least;
            answers[part].push_back(ends ? float(-std::log(before)) : CarriedLight::no_ray);
            found += ends;
          }
          front.add(row, first, 0);
        });
    const auto answered = team_.exchange(answers);
    for (int rank = 0; rank < team_.size(); ++rank) {
      const PixelBox box = common(own.pixels(), strip_of(rank));
      const float* from = answered[std::size_t(rank)].data();
      for_rows(box, [&](const glm::ivec2& first) {
        std::copy_n(from, box.size.x, depths.begin() + std::ptrdiff_t(own.index(first, sample)));
        from += box.size.x;
      });
    }
  }
  // a member without rays goes on with the others
  if (team_.sum(found) == 0) return {};
  return depths;
}

Image Strips::picture(const CarriedLight& own, bool transmittance) const {
  CarriedLight light(own.fold(), strip_of(team_.rank()), own.samples());
  for (int sample = 0; sample < own.samples(); ++sample)
    join<glm::vec4>(
        own, sample, [](const glm::dvec4& ray) { return glm::vec4(ray); },
        [&](std::size_t, const glm::ivec2& first, std::span<const glm::vec4> row) {
          light.add(row, first, sample);
        });
  Image picture = light.picture(transmittance);
  for (Layer& layer : picture.layers) {
    const auto strips = team_.collect(layer.values);
    layer.values.clear();
    for (const auto& part : strips)
      layer.values.insert(layer.values.end(), part.begin(), part.end());
  }
  if (!team_.first()) return {};
  picture.width = view_.scene.resolution.x;
  picture.height = view_.scene.resolution.y;
  return picture;
}

/// Counts of all members, and the times of the slowest.
void add_up(Team& team, RenderStats& stats) {
  for (std::uint64_t RenderStats::*count :
       {&RenderStats::samples, &RenderStats::steps, &RenderStats::stuck})
    stats.*count = team.sum(stats.*count);
  stats.cpu_ms = team.sum(stats.cpu_ms);
  for (double RenderStats::*time : {&RenderStats::shader_ms, &RenderStats::upload_ms,
                                    &RenderStats::march_ms, &RenderStats::gpu_ms})
    stats.*time = std::ranges::max(team.gather(stats.*time));
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
    if (auto depths = strips.ending(light)) {
      light.begin_behind(std::move(*depths));
      RenderOptions again = options;
      again.progress = {};
      team_.agree([&] { carry(light, view, again, stats); });
    }
    result.image = strips.picture(light, options.transmittance);
    add_up(team_, stats);
  }
  stats.rays = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(samples);
  if (options.pilot) {
    RenderOptions few = options;
    few.pilot.reset();
    few.tile = {};
    few.progress = {};
    result.pilot = render(*options.pilot, few).image;
  }
  return result;
}

void PartMarcher::carry(CarriedLight& light, const View& view, const RenderOptions& options,
                        RenderStats& stats) {
  drop_dark();
  View one = view;
  one.scene.pixel_samples = 1;
  const int samples = light.samples();
  const glm::ivec3 ghost = region_ghost(one);
  const auto regions = split_.own.front_to_back(view.camera, view.medium.density->world_from_index);
  RenderOptions part = options;
  part.pilot.reset();
  part.transmittance = false;  // it is in the picture
  part.tile = {};
  double done = 0;
  const double share = 1.0 / double(regions.size() * std::size_t(samples));
  if (options.progress)
    part.progress = [&](double fraction) { options.progress(share * (done + fraction)); };
  stats.renderer = marcher_.description();
  for (const Region& region : regions) {
    const PixelBox seen = common(pixels_of(view, region.bricks), light.pixels());
    if (seen.empty() || light.ended(seen)) {
      done += samples;
      continue;
    }
    part.pixels = seen;
    MediumAtlas atlas = build_region_atlas(view, region.bricks, ghost);
    if (const CodeWidths widths = fixed_widths(atlas, view.scene.texel))
      atlas = coded(std::move(atlas), *widths);
    marcher_.upload_once(atlas, view.scene.filter);
    for (int sample = 0; sample < samples; ++sample, ++done) {
      part.place = pixel_sample(sample, samples);
      if (part.depth || light.fold().ends_by_passed()) part.passed = light.passed(seen, sample);
      const RenderResult drawn = marcher_.render(one, part);
      light.add(drawn.image, seen.origin, sample);
      add_counts(drawn.stats, stats);
    }
  }
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
  View dark = view;
  dark.medium.luminance.reset();
  dark_ = build_region_atlas(dark, bricks);
  marcher_.upload_once(dark_, Filter::exact);
  uploaded_ = bricks;
}

void PartMarcher::drop_dark() {
  uploaded_.reset();
  dark_ = {};
}

}  // namespace psivox
