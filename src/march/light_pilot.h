#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "march/light.h"

namespace psivox {

/// Some points of a picture, spread over its rays by what is seen of them, and the exact light at
/// voxels beside them. From what a computed light misses there it estimates what the picture
/// misses.
class LightPilot {
 public:
  /// Exact optical depths from some voxels towards a beam.
  using Depths =
      std::function<std::vector<double>(const Beam& beam, std::span<const glm::ivec3> voxels)>;

  /// `view`: its light is still to be computed. `luminance` is of that view and of the beams to
  /// compare with, whose methods do not matter. Both must outlive the pilot.
  LightPilot(const View& view, Depths exact, const LitLuminance& luminance);

  /// Voxels whose luminance is compared.
  std::span<const glm::ivec3> voxels() const { return voxels_; }

  /// Cells with attenuation that a ray from a voxel of the medium towards the beams crosses before
  /// it ends at that transmittance, on average.
  double mean_cells(double termination) const;

  /// RMS over the picture's pixels and R G B A of what they miss in the light of `lit`, which has
  /// its luminance at `voxels`.
  double rms(const Medium& lit) const;
  /// The same of other beams, whose light is computed exactly.
  double rms(const LitLuminance& luminance) const;

 private:
  struct Ray {
    std::size_t first = 0;  ///< of its voxels
    double opacity = 0;
    glm::dvec3 direction{0};
  };
  void place_points(double rays);
  std::vector<glm::dvec3> exact_light(const LitLuminance& luminance) const;
  /// `light` at the voxels, and the factor of each ray that is in it.
  double rms(const std::vector<glm::dvec3>& light,
             const std::function<double(const Ray&)>& phase) const;

  const View& view_;
  Depths exact_;
  const LitLuminance& luminance_;
  std::vector<Ray> rays_;  ///< those that meet the medium
  std::size_t all_rays_ = 0;
  std::vector<glm::ivec3> voxels_;  ///< points_per_ray of each ray
  std::vector<glm::dvec3> truth_;   ///< luminance there
};

}  // namespace psivox
