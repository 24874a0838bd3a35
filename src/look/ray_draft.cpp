#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "look/draft.h"
#include "look/voxel_lines.h"
#include "scene/clip.h"
#include "scene/transfer_function.h"

namespace psivox {
namespace {

constexpr glm::ivec2 size(64, 36);
/// Rays end at this transmittance, and look at the light again each time that they lost so much.
constexpr double opaque = 0.01, light_interval = 0.1;

struct DraftLight {
  VoxelLines::Line towards;
  glm::dvec3 radiance;
};

/// Draws rays, a voxel at a time.
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

  /// Radiance and opacity of a ray.
  glm::dvec4 draw(const WorldRay& ray) {
    const VoxelLines::Line line =
        lines_.line(glm::dvec3(to_index_ * glm::dvec4(ray.origin, 1)), ray.direction);
    const Box domain = medium_.density->domain();
    const glm::dvec3 a = (glm::dvec3(domain.min) - line.from) / line.way;
    const glm::dvec3 b = (glm::dvec3(domain.max) - line.from) / line.way;
    const glm::dvec3 near = glm::min(a, b), far = glm::max(a, b);
    const glm::dvec2 left = clip_interval(clip_, ray) / line.step;
    const double enters = std::max({near.x, near.y, near.z, 0.0, left.x});
    double through = 1, lit_at = 2;
    glm::dvec3 radiance(0), beams(0);
    if (!(enters < std::min({far.x, far.y, far.z, left.y}))) return glm::dvec4(0);
    const double begin = enters + 0.5;
    lines_.walk_between(line, begin, [&](double n, double between) {
      if (begin + n > left.y) return false;
      const auto value = double(float(between));
      const double depth = medium_.extinction * line.step * lines_.attenuation(value);
      if (!(depth > 0)) return true;
      if (through < lit_at - light_interval) {
        beams = light_at(glm::ivec3(glm::round(line.from + (begin + n) * line.way)));
        lit_at = through;
      }
      const double passed = through * std::exp(-depth);
      radiance += (through - passed) * luminance(value, beams);
      through = passed;
      return through > opaque;
    });
    return glm::dvec4(radiance, 1 - through);
  }

 private:
  glm::dvec3 light_at(const glm::ivec3& voxel) {
    glm::dvec3 sum(0);
    for (const DraftLight& light : lights_) {
      const double depth = lines_.depth_of(voxel) + lines_.depth_behind(voxel, light.towards);
      sum += light.radiance * std::exp(-medium_.extinction * light.towards.step * depth);
    }
    return sum;
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
  const bool sky =
      medium.light && (medium.light->sky != glm::dvec3(0) || !view.scene.environment.empty());
  return view.scene.composites() && !info(view.scene.mode).from_back && source && !sky &&
         !(medium.light && !medium.light->albedo.empty()) && !medium.emission && !medium.gradient &&
         view.scene.phase_g == 0 && view.scene.scatter_octaves == 1;
}

}  // namespace

std::optional<Draft> ray_draft(const View& view) {
  if (!suits_rays(view)) return {};
  RayDraft rays(view);
  Draft draft;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec4 seen = rays.draw(camera_ray(view.camera, size, x + 0.5, y + 0.5));
      draft.see(glm::dvec3(seen), seen.w);
    }
  draft.sort();
  return draft;
}

}  // namespace psivox
