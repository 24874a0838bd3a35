#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "field/index_space.h"
#include "march/light.h"
#include "psivox/team.h"

namespace psivox {

/// What this process has of a medium that a team lights together; a process that is alone has all.
struct LightShare {
  Team* team = alone().get();
  /// Voxels that none but this process has.
  Box voxels = everywhere;
  /// The leaves of the whole density, without values; null: the medium's density has them.
  std::shared_ptr<const Field> whole{};

  bool together() const { return team->size() > 1; }
  /// What each process gives of its share.
  template <typename Values>
  auto of_all(const Values& own) const {
    return team->gather(own);
  }
};

/// What a picture misses in its light.
struct LightError {
  double rms = 0;  ///< over the pixels and R G B A
  double max = 0;  ///< of one channel of a ray

  LightError operator*(double factor) const { return {rms * factor, max * factor}; }
};

/// The error of independent parts of the light together.
LightError sum(const LightError& a, const LightError& b);

/// Some points of a picture, spread over its rays by what is seen of them, and the exact light at
/// voxels beside them. From what a computed light misses there it estimates what the picture
/// misses. Rays are drawn by the square of their opacity, by which their light's error counts: a
/// small opaque thing in a thin haze is looked at.
class LightPilot {
 public:
  /// Exact optical depths from some voxels towards a beam, through the whole medium.
  using Depths =
      std::function<std::vector<double>(const Beam& beam, std::span<const glm::ivec3> voxels)>;

  /// `view`: its light is still to be computed. `luminance` is of that view and of the beams to
  /// compare with, whose methods do not matter. All must outlive the pilot. The members of a team
  /// make the same pilot together, and ask it the same.
  LightPilot(const View& view, Depths exact, const LitLuminance& luminance,
             const LightShare& share);

  /// Mean square of the opacity of the picture's rays. The picture's error grows with its root.
  double coverage() const { return coverage_; }

  /// Voxels whose luminance is compared.
  std::span<const glm::ivec3> voxels() const { return voxels_; }

  /// Cells with attenuation that a ray from a voxel of the medium towards the beams crosses before
  /// it ends at that transmittance, on average.
  double mean_cells(double termination) const;

  /// What the picture misses in the light of `lit`, which has its luminance at `voxels`. The
  /// maximum is of these rays, whose points' own noise enlarges it.
  LightError error(const Medium& lit) const;
  /// What the picture misses in the light of other beams, which is computed exactly.
  LightError error(const LitLuminance& luminance) const;

 private:
  struct Ray {
    std::size_t first = 0;  ///< of its voxels
    double opacity = 0;
    glm::dvec3 direction{0};
  };
  /// Luminance at a voxel, or its factor, where this process knows it.
  struct Known {
    glm::dvec3 light{0};
    bool known = false;
  };
  /// That of all voxels, which the members of a team know together.
  std::vector<glm::dvec3> known(const std::vector<Known>& own) const;

  void place_points(double rays);
  std::vector<glm::dvec3> exact_light(const LitLuminance& luminance) const;
  /// `light` at the voxels, and the factor of each ray that is in it.
  LightError error(const std::vector<glm::dvec3>& light,
                   const std::function<double(const Ray&)>& phase) const;

  const View& view_;
  Depths exact_;
  const LitLuminance& luminance_;
  const LightShare& share_;
  std::vector<Ray> rays_;
  double coverage_ = 0;
  std::vector<glm::ivec3> voxels_;  ///< points_per_ray of each ray
  std::vector<glm::dvec3> tints_;   ///< factor of the light there, if the function gives colours
  std::vector<glm::dvec3> truth_;   ///< luminance there
};

}  // namespace psivox
