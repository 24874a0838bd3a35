#include "look/voxel_lines.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numeric>

#include "field/index_space.h"
#include "field/value_range.h"
#include "look/choices.h"
#include "march/light.h"
#include "march/voxel_luminance.h"
#include "psivox/draw.h"
#include "psivox/scene.h"
#include "scene/cuts.h"

namespace psivox {

VoxelLines::VoxelLines(const Medium& medium)
    : function_(without_colors(medium)),
      density_(*medium.density),
      nearest_(medium.nearest),
      domain_(medium.density->domain()),
      to_index_(glm::inverse(glm::dmat3(medium.density->world_from_index))),
      empty_is_clear_(attenuation(0) == 0) {}

VoxelLines::Line VoxelLines::line(const glm::dvec3& from, const glm::dvec3& direction) const {
  const glm::dvec3 way = to_index_ * direction;
  const double step = 1 / glm::length(way);
  return {from, step * way, step * glm::length(direction)};
}

double VoxelLines::attenuation(double value) const {
  return function_ ? function_->attenuation(value) : std::max(0.0, value);  // NaN: 0
}

double VoxelLines::depth_behind(const glm::ivec3& voxel, const Line& along, double most) {
  double sum = 0;
  walk({glm::dvec3(voxel), along.way, along.step}, 1, [&](double value) {
    sum += attenuation(value);
    return sum <= most;
  });
  return sum;
}

namespace {

/// The part of the light that reaches the medium, and the least extinction by the view's own. The
/// mean ray, by which that is chosen, passes between the vessels of a sparse medium.
struct Wanted {
  double share, least;
};
constexpr Wanted dense_medium{1.0 / 3, 1}, sparse_medium{0.6, 1.0 / 8};
/// No more than this times the view's own extinction: a medium of few voxels stays thin. Where
/// voxels are flat, a medium of many is thin in the world: as many times more.
constexpr double most_times = 16;
constexpr std::size_t most_voxels = 2048;

/// The longest edge of a voxel in shortest ones.
double flatness(const Field& field) {
  const glm::dmat3 edges(field.world_from_index);
  const auto [shortest, longest] =
      std::minmax({glm::length(edges[0]), glm::length(edges[1]), glm::length(edges[2])});
  return longest / shortest;
}

/// A voxel's attenuation at extinction 1, and the optical depth from it to the light.
struct Probe {
  double attenuation = 0, depth = 0;
};

class Probes {
 public:
  Probes(const View& view, const glm::dvec3& light) {
    VoxelLines lines(view.medium);
    const VoxelLines::Line towards = lines.line({}, -light);
    for (const auto& [voxel, value] : sample_voxels(*view.medium.density, most_voxels))
      if (const double here = lines.attenuation(double(value)); here > 0)
        probes_.push_back({here, towards.step * lines.depth_behind(voxel, towards)});
  }

  /// Mean transmittance towards the light, by what each voxel attenuates.
  double mean(double extinction) const {
    double sum = 0, weights = 0;
    for (const Probe& probe : probes_) {
      sum += probe.attenuation * std::exp(-extinction * probe.depth);
      weights += probe.attenuation;
    }
    return weights > 0 ? sum / weights : 1;
  }

 private:
  std::vector<Probe> probes_;
};

}  // namespace

double light_extinction(const View& view, bool sparse) {
  const auto [wanted_share, least_part] = sparse ? sparse_medium : dense_medium;
  const std::vector<ParallelLight> lights = surface_lights(view);
  const double least = least_part * view.medium.extinction;
  if (lights.empty() || !(least > 0)) return least;
  const Probes probes(view, lights.front().direction);
  if (probes.mean(least) <= wanted_share) return least;
  double low = least, high = most_times * flatness(*view.medium.density) * view.medium.extinction;
  // single voxels hide no others from the light, and more would only whiten them
  if (probes.mean(high) > wanted_share) return view.medium.extinction;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (probes.mean(middle) > wanted_share ? low : high) = middle;
  }
  return low;
}

namespace {

/// A pixel counts if it hides this much or is that bright.
constexpr double covered_alpha = 0.5;
constexpr double covered_luminance = 0.1;
/// And glows with this part of the brightest one.
constexpr float glowing = 0.01f;

/// The value that this part of ascending ones exceeds.
template <typename Number>
Number exceeded_by(const std::vector<Number>& ascending, double part) {
  if (ascending.empty()) return 0;
  return ascending[std::size_t(double(ascending.size() - 1) * (1 - part))];
}

/// Whatever method is given for the picture.
Method draft_method(const Scene& scene, const Field& density) {
  if (scene.emission_grid.empty())
    return {.integrator = Integrator::psi_balanced, .sampling = Sampling::uniform, .step = 2};
  // light that leaves less than a step needs cells
  constexpr double step = 4;
  const double most = scene.extinction.value_or(0) * stored_range(density).y;
  if (most * step * glm::length(glm::dvec3(density.world_from_index[0])) > 8)
    return {.segments = 2};
  // a step looks up one value
  return {.integrator = Integrator::midpoint, .sampling = Sampling::uniform, .step = step};
}

constexpr glm::ivec2 ray_count(64, 36);
/// Every second ray, as on a chessboard, is enough if so many pixels are covered: the brightness by
/// them was within 1 % of that by 16 times as many rays, on four files.
constexpr std::size_t enough_pixels = 200;
/// Rays end at this transmittance, and look at the light again each time that they lost so much;
/// rays towards the light at this depth, behind which it is less than float32 has beside it.
constexpr double opaque = 0.01, light_interval = 0.1, dark = 17;

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
    if (medium_.source == LuminanceSource::transfer) colors_.emplace(*medium_.transfer);
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
    const glm::dvec2 in = interval_in(domain.min, domain.max, line.from, line.way);
    const glm::dvec2 left = clip_interval(clip_, ray) / line.step;
    const double enters = std::max({in.x, 0.0, left.x});
    double through = 1, lit_at = 2;
    glm::dvec3 radiance(0), beams(0);
    if (!(enters < std::min(in.y, left.y))) return glm::dvec4(0);
    const double begin = enters + 0.5;
    lines_.walk_between(line, begin, [&](double n, double between) {
      if (begin + n > left.y) return false;
      const auto value = float(between);
      const double depth = medium_.extinction * line.step * lines_.attenuation(double(value));
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
      const double scale = medium_.extinction * light.towards.step;
      const double depth =
          lines_.depth_of(voxel) + lines_.depth_behind(voxel, light.towards, dark / scale);
      sum += light.radiance * std::exp(-scale * depth);
    }
    return sum;
  }

  glm::dvec3 luminance(float value, const glm::dvec3& beams) const {
    if (!colors_) return medium_.color + beams;
    const glm::dvec3 color = colors_->at(value);
    return medium_.color * color + (medium_.light && medium_.light->tinted ? beams * color : beams);
  }

  const Medium& medium_;
  std::vector<HalfSpace> clip_;
  VoxelLines lines_;
  glm::dmat4 to_index_;
  std::optional<FunctionColors> colors_;
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
         !(medium.light && !medium.light->albedo.empty()) && medium.emission.empty() &&
         !medium.gradient && view.scene.phase_g == 0 && view.scene.scatter_octaves == 1;
}

}  // namespace

double Draft::mean_luminance() const {
  if (luminance.empty()) return 0;
  return std::accumulate(luminance.begin(), luminance.end(), 0.0) / double(luminance.size());
}

double Draft::level(double part) const { return exceeded_by(brightest, part); }

void Draft::see(const glm::dvec3& radiance, double alpha) {
  const double light = 0.2126 * radiance.x + 0.7152 * radiance.y + 0.0722 * radiance.z;
  if (alpha < covered_alpha && light < covered_luminance) return;
  luminance.push_back(light);
  brightest.push_back(std::max({radiance.x, radiance.y, radiance.z}));
}

void Draft::sort() {
  std::sort(luminance.begin(), luminance.end());
  std::sort(brightest.begin(), brightest.end());
}

Image draft_picture(Scene scene, const MediumFields& fields) {
  scene.background.reset();
  scene.holdout.clear();
  scene.holdout_depth = Scene{}.holdout_depth;
  scene = with_method(scene, draft_method(scene, *fields.density));
  scene.connectivity = Scene{}.connectivity;
  scene.resolution = {96, 54};
  scene.pixel_samples = 1;
  scene.memory_limit = 0;  // its march in double needs the whole atlas, on the host alone
  return Session(make_view(scene, fields)).draw(*open_double(), {.any_light = true}).image;
}

Draft make_draft(const Scene& scene, const MediumFields& fields) {
  const Image image = draft_picture(scene, fields);
  Draft draft;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    draft.see(glm::dvec3(rgba[i], rgba[i + 1], rgba[i + 2]), double(rgba[i + 3]));
  draft.sort();
  return draft;
}

double glow_level(const Image& image, double part) {
  std::vector<float> glow;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    glow.push_back(std::max({rgba[i], rgba[i + 1], rgba[i + 2]}));
  const float least = glowing * std::ranges::max(glow);
  std::erase_if(glow, [&](float value) { return !(value > 0 && value >= least); });
  std::ranges::sort(glow);
  return double(exceeded_by(glow, part));
}

std::optional<Draft> ray_draft(const View& view) {
  if (!suits_rays(view)) return {};
  const RayDraft rays(view);
  Draft draft;
  for (int odd = 0; odd < 2 && draft.luminance.size() < enough_pixels; ++odd) {
    std::vector<glm::dvec4> seen(std::size_t(ray_count.x) * ray_count.y / 2);
    tbb::parallel_for(tbb::blocked_range<int>(0, ray_count.y, 4), [&](const auto& rows) {
      RayDraft own = rays;
      for (int y = rows.begin(); y != rows.end(); ++y)
        for (int i = 0; i < ray_count.x / 2; ++i)
          seen[std::size_t(y * ray_count.x / 2 + i)] =
              own.draw(camera_ray(view.camera, ray_count, 2 * i + (y + odd) % 2 + 0.5, y + 0.5));
    });
    for (const glm::dvec4& ray : seen) draft.see(glm::dvec3(ray), ray.w);
  }
  draft.sort();
  return draft;
}

}  // namespace psivox
