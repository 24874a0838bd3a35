#include "look/voxel_lines.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "field/index_space.h"
#include "field/value_range.h"
#include "look/choices.h"
#include "march/light.h"
#include "psivox/draw.h"
#include "psivox/scene.h"

namespace psivox {

VoxelLines::VoxelLines(const Medium& medium)
    : function_(without_colors(medium)),
      density_(*medium.density),
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

/// A pixel glows with this part of the brightest one.
constexpr float glowing = 0.01f;

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

}  // namespace

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

double glow_level(const Image& image, double part) {
  std::vector<float> glow;
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4)
    glow.push_back(std::max({rgba[i], rgba[i + 1], rgba[i + 2]}));
  const float least = glowing * std::ranges::max(glow);
  std::erase_if(glow, [&](float value) { return !(value > 0 && value >= least); });
  std::ranges::sort(glow);
  if (glow.empty()) return 0;
  return double(glow[std::size_t(double(glow.size() - 1) * (1 - part))]);
}

}  // namespace psivox
