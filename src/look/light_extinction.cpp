#include "look/light_extinction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "look/field_sample.h"
#include "look/voxel_lines.h"

namespace psivox {
namespace {

/// The part of the light that reaches the medium, and the least extinction by the view's own. The
/// mean ray, by which that is chosen, passes between the vessels of a sparse medium.
struct Wanted {
  double share, least;
};
constexpr Wanted dense_medium{1.0 / 3, 1}, sparse_medium{0.6, 1.0 / 8};
/// No more than this times the view's own extinction: a thin medium stays one.
constexpr double most = 16;
constexpr std::size_t most_voxels = 2048;

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
  double low = least, high = most * view.medium.extinction;
  // single voxels hide no others from the light, and more would only whiten them
  if (probes.mean(high) > wanted_share) return view.medium.extinction;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (probes.mean(middle) > wanted_share ? low : high) = middle;
  }
  return low;
}

}  // namespace psivox
