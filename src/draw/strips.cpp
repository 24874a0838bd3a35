#include "draw/strips.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace psivox {

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
static void for_rows(const PixelBox& box, const Each& each) {
  for (int y = 0; y < box.size.y; ++y) each(box.origin + glm::ivec2(0, y));
}

template <typename Number, typename Of>
std::vector<std::vector<Number>> Strips::sent_to_strips(const CarriedLight& own, int sample,
                                                        const Of& of) const {
  std::vector<std::vector<Number>> sent(std::size_t(team_.size()));
  for (int rank = 0; rank < team_.size(); ++rank) {
    const PixelBox box = common(own.pixels(), strip_of(rank));
    for_rows(box, [&](const glm::ivec2& first) {
      for (const glm::dvec4& ray : own.row(first, box.size.x, sample))
        sent[std::size_t(rank)].push_back(of(ray));
    });
  }
  return team_.exchange(sent);
}

std::vector<float> Strips::ending(const CarriedLight& own) const {
  const RayFold& fold = own.fold();
  const double least = fold.least_transmittance();
  if (!(least > 0)) return {};
  const PixelBox strip = strip_of(team_.rank());
  std::vector<float> depths(own.rays());
  std::uint64_t found = 0;
  for (int sample = 0; sample < own.samples(); ++sample) {
    const auto received = sent_to_strips<float>(
        own, sample, [&](const glm::dvec4& ray) { return float(fold.transmittance(ray)); });
    std::vector<std::vector<float>> answers(received.size());
    CarriedLight front(fold, strip, 1);
    for (const Region& part : order_) {
      const PixelBox box = common(seen_[part.number], strip);
      std::span<const float> through = received[part.number];
      for_rows(box, [&](const glm::ivec2& first) {
        std::vector<glm::vec4> row;
        const auto rays = front.row(first, box.size.x, 0);
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const double before = rays[i].a;
          row.emplace_back(0, 0, 0, through[i]);
          const bool ends = before < 1 && before > least && before * double(through[i]) <= least;
          answers[part.number].push_back(ends ? float(-std::log(before)) : CarriedLight::no_ray);
          found += ends;
        }
        front.add(row, first, 0);
        through = through.subspan(rays.size());
      });
    }
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
  if (team_.sum(found) == 0) depths.clear();
  return depths;
}

Image Strips::picture(const CarriedLight& own, bool transmittance) const {
  const PixelBox strip = strip_of(team_.rank());
  CarriedLight light(own.fold(), strip, own.samples());
  for (int sample = 0; sample < own.samples(); ++sample) {
    const auto received = sent_to_strips<glm::vec4>(
        own, sample, [](const glm::dvec4& ray) { return glm::vec4(ray); });
    for (const Region& part : order_) {
      const PixelBox box = common(seen_[part.number], strip);
      std::span<const glm::vec4> rows = received[part.number];
      for_rows(box, [&](const glm::ivec2& first) {
        light.add(rows.first(std::size_t(box.size.x)), first, sample);
        rows = rows.subspan(std::size_t(box.size.x));
      });
    }
  }
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

void add_up(Team& team, RenderStats& stats) {
  for (std::uint64_t RenderStats::*count :
       {&RenderStats::samples, &RenderStats::steps, &RenderStats::stuck})
    stats.*count = team.sum(stats.*count);
  stats.cpu_ms = team.sum(stats.cpu_ms);
  for (double RenderStats::*time : {&RenderStats::shader_ms, &RenderStats::upload_ms,
                                    &RenderStats::march_ms, &RenderStats::gpu_ms})
    stats.*time = std::ranges::max(team.gather(stats.*time));
}

}  // namespace psivox
