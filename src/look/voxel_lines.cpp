#include "look/voxel_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "look/choices.h"
#include "march/light.h"

namespace psivox {

VoxelLines::VoxelLines(const Medium& medium)
    : function_(without_colors(medium)),
      index_(*medium.density),
      domain_(medium.density->domain()),
      to_index_(glm::inverse(glm::dmat3(medium.density->world_from_index))),
      empty_is_clear_(attenuation(0) == 0),
      block_(index_.block(domain_.min & ~7)),
      origin_(domain_.min & ~7) {}

VoxelLines::Line VoxelLines::line(const glm::dvec3& from, const glm::dvec3& direction) const {
  const glm::dvec3 way = to_index_ * direction;
  const double step = 1 / glm::length(way);
  return {from, step * way, step * glm::length(direction)};
}

double VoxelLines::attenuation(double value) const {
  return function_ ? function_->at(value).attenuation : std::max(value, 0.0);
}

double VoxelLines::depth_behind(const glm::ivec3& voxel, const Line& along, double most) {
  double sum = 0;
  walk({glm::dvec3(voxel), along.way, along.step}, 1, [&](double value) {
    sum += attenuation(value);
    return sum <= most;
  });
  return sum;
}

double VoxelLines::at(const glm::ivec3& voxel) {
  const glm::ivec3 origin = voxel & ~7;
  if (origin != origin_) block_ = index_.block(origin_ = origin);
  return double(*block_.values.at(voxel - origin));
}

double VoxelLines::at(const glm::dvec3& point) {
  const glm::ivec3 cell = nearest_voxel(point - 0.5), local = cell & 7;
  const glm::dvec3 u = point - glm::dvec3(cell);
  std::array<double, 8> corners;  // z fastest
  if (std::max({local.x, local.y, local.z}) < 7) {
    at(cell);
    const float* first = block_.values.at(local);
    const Strides& s = block_.values.strides;
    for (std::size_t i = 0; i < 8; ++i)
      corners[i] = double(first[(i >> 2) * s.x + (i >> 1 & 1) * s.y + (i & 1) * s.z]);
  } else {
    for (int i = 0; i < 8; ++i)
      corners[std::size_t(i)] = at(cell + glm::ivec3(i >> 2, i >> 1 & 1, i & 1));
  }
  const auto along_z = [&](std::size_t i) { return glm::mix(corners[i], corners[i + 1], u.z); };
  return glm::mix(glm::mix(along_z(0), along_z(2), u.y), glm::mix(along_z(4), along_z(6), u.y),
                  u.x);
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
constexpr double most = 16;
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
  double low = least, high = most * flatness(*view.medium.density) * view.medium.extinction;
  // single voxels hide no others from the light, and more would only whiten them
  if (probes.mean(high) > wanted_share) return view.medium.extinction;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (probes.mean(middle) > wanted_share ? low : high) = middle;
  }
  return low;
}

}  // namespace psivox
