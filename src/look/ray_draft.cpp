#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <span>
#include <utility>
#include <vector>

#include "look/draft.h"
#include "look/voxel_lines.h"
#include "psivox/clip.h"
#include "psivox/leaf_values.h"

namespace psivox {
namespace {

constexpr glm::ivec2 size(64, 36);
/// Rays end at this transmittance, and look at the light again each time that they lost so much.
constexpr double opaque = 0.01, light_interval = 0.1;

struct DraftLight {
  VoxelLines::Line towards;
  glm::dvec3 radiance;
};

/// A ray's value between voxels at a point of its line.
struct Met {
  std::uint32_t ray, n;
  float value;
};

/// Draws rays, a voxel at a time, many at once: where several processes share the density, each
/// knows its own part of a ray alone, and all of them draw the same.
class RayDraft {
 public:
  explicit RayDraft(const View& view)
      : medium_(view.medium),
        clip_(clip_of(view.scene)),
        lines_(medium_),
        to_index_(glm::inverse(medium_.density->world_from_index)) {
    if (!medium_.light) return;
    for (const ParallelLight& light : medium_.light->lights)
      lights_.push_back(
          {lines_.line({}, -(light.of_camera ? from_camera(view.camera, light.direction)
                                             : light.direction)),
           light.radiance});
  }

  /// Radiance and opacity of each ray.
  std::vector<glm::dvec4> draw(const std::vector<WorldRay>& rays) {
    std::vector<Ray> lines;
    for (const WorldRay& ray : rays) lines.push_back(enter(ray));
    const std::vector<Met> all = met(lines);
    std::vector<Step> steps;
    std::vector<glm::ivec3> lit;  // where light is looked at
    std::vector<glm::dvec4> seen;
    auto next = all.begin();
    for (std::size_t ray = 0; ray < lines.size(); ++ray) {
      double through = 1, lit_at = 2;
      for (; next != all.end() && next->ray == ray; ++next) {
        const double depth = depth_at(lines[ray], next->value);
        if (!(through > opaque)) continue;
        if (through < lit_at - light_interval) {
          lit.push_back(glm::ivec3(glm::round(lines[ray].at(next->n))));
          lit_at = through;
        }
        const double left = through * std::exp(-depth);
        steps.push_back({ray, lit.size() - 1, through - left, next->value});
        through = left;
      }
      seen.emplace_back(0, 0, 0, 1 - through);
    }
    const std::vector<glm::dvec3> beams = light_at(lit);
    for (const Step& step : steps)
      seen[step.ray] += glm::dvec4(step.hidden * luminance(double(step.value), beams[step.lit]), 0);
    return seen;
  }

 private:
  /// A ray from where it enters the domain and what the clip leaves.
  struct Ray {
    VoxelLines::Line line;
    double begin;
    double end;  ///< of what the clip leaves
    bool meets;
    glm::dvec3 at(std::uint32_t n) const { return line.from + (begin + double(n)) * line.way; }
  };

  /// What a ray meets at a point, and where light was looked at last.
  struct Step {
    std::size_t ray, lit;
    double hidden;
    float value;
  };

  Ray enter(const WorldRay& ray) const {
    const VoxelLines::Line line =
        lines_.line(glm::dvec3(to_index_ * glm::dvec4(ray.origin, 1)), ray.direction);
    const Box domain = medium_.density->domain();
    const glm::dvec3 a = (glm::dvec3(domain.min) - line.from) / line.way;
    const glm::dvec3 b = (glm::dvec3(domain.max) - line.from) / line.way;
    const glm::dvec3 near = glm::min(a, b), far = glm::max(a, b);
    const glm::dvec2 left = clip_interval(clip_, ray) / line.step;
    const double begin = std::max({near.x, near.y, near.z, 0.0, left.x});
    return {line, begin + 0.5, left.y, begin < std::min({far.x, far.y, far.z, left.y})};
  }

  double depth_at(const Ray& ray, float value) const {
    return medium_.extinction * ray.line.step * lines_.attenuation(double(value));
  }

  /// What attenuates along the rays, in their order.
  std::vector<Met> met(const std::vector<Ray>& rays) {
    std::vector<Met> own;
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
      double through = 1;
      if (rays[ray].meets)
        lines_.walk_between(rays[ray].line, rays[ray].begin, [&](std::uint32_t n, double between) {
          if (rays[ray].begin + double(n) > rays[ray].end) return false;
          const auto value = float(between);
          const double depth = depth_at(rays[ray], value);
          if (!(depth > 0)) return true;
          own.push_back({std::uint32_t(ray), n, value});
          through *= std::exp(-depth);
          return through > opaque;
        });
    }
    std::vector<Met> all = joined_found(*medium_.density, own);
    std::ranges::sort(all, {}, [](const Met& some) { return std::pair(some.ray, some.n); });
    return all;
  }

  std::vector<glm::dvec3> light_at(const std::vector<glm::ivec3>& voxels) {
    std::vector<double> depths;
    for (const glm::ivec3& voxel : voxels)
      for (const DraftLight& light : lights_)
        depths.push_back(lines_.depth_of(voxel) + lines_.depth_behind(voxel, light.towards));
    sum_found(*medium_.density, std::span(depths));
    std::vector<glm::dvec3> sums(voxels.size(), glm::dvec3(0));
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const DraftLight& light = lights_[i % lights_.size()];
      sums[i / lights_.size()] +=
          light.radiance * std::exp(-medium_.extinction * light.towards.step * depths[i]);
    }
    return sums;
  }

  glm::dvec3 luminance(double value, const glm::dvec3& beams) const {
    if (medium_.source == LuminanceSource::constant) return medium_.color + beams;
    const glm::dvec3 color = medium_.transfer->at(value).color;
    return medium_.color * color + (medium_.light && medium_.light->tinted ? beams * color : beams);
  }

  const Medium& medium_;
  std::vector<HalfSpace> clip_;
  VoxelLines lines_;
  glm::dmat4 to_index_;
  std::vector<DraftLight> lights_;
};

/// Whether rays through voxels know all that it glows by.
bool suits_rays(const View& view) {
  const Medium& medium = view.medium;
  const bool source =
      medium.source == LuminanceSource::constant || medium.source == LuminanceSource::transfer;
  const bool sky = medium.light && medium.light->sky != glm::dvec3(0);
  return view.scene.composites() && !info(view.scene.mode).from_back && source && !sky &&
         !medium.emission && !medium.gradient && view.scene.phase_g == 0;
}

}  // namespace

std::optional<Draft> ray_draft(const View& view) {
  if (!suits_rays(view)) return {};
  RayDraft rays(view);
  Draft draft;
  for (int y = 0; y < size.y; ++y) {  // by rows: a row's values are few megabytes
    std::vector<WorldRay> row;
    for (int x = 0; x < size.x; ++x) row.push_back(camera_ray(view.camera, size, x + 0.5, y + 0.5));
    for (const glm::dvec4& seen : rays.draw(row)) draft.see(glm::dvec3(seen), seen.w);
  }
  draft.sort();
  return draft;
}

}  // namespace psivox
