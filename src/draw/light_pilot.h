#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "field/index_space.h"
#include "march/light.h"
#include "march/march_double.h"
#include "march/volume_depths.h"
#include "psivox/team.h"

namespace psivox {

/// What this process has of a medium that a team lights together; a process that is alone has all.
struct LightShare {
  Team* team = alone().get();
  /// Voxels that none but this process has.
  Box voxels = everywhere;

  bool together() const { return team->size() > 1; }
};

/// What a picture misses in its light.
struct LightError {
  double rms = 0;  ///< over the pixels and R G B A
  double max = 0;  ///< of one channel of a ray

  LightError operator*(double factor) const { return {rms * factor, max * factor}; }
};

/// The error of independent parts of the light together.
LightError sum(const LightError& a, const LightError& b);

/// Exact optical depths from some voxels towards a beam, through the whole medium.
using ExactDepths =
    std::function<std::vector<double>(const Beam& beam, std::span<const glm::ivec3> voxels)>;

/// What rays of a view cross of its first volume (crossed_cells in march_double.h).
using CrossedCells = std::function<std::vector<std::vector<Crossed>>(
    const View& view, std::span<const glm::dvec2> places)>;

/// Where optical depths towards lights come from: through the atlas of the whole, or part by part.
/// Of several volumes those of a marcher are through the first alone.
struct LightSource {
  std::function<LightDepths(const View& view)> depths;
  std::function<ExactDepths(const View& view)> exact_depths;
  CrossedCells crossed;
  const MediumAtlas* atlas = nullptr;  ///< of the whole, if it is there
  LightShare share{};
};

/// Depths through the whole medium of a view, from voxels of each of its volumes.
class MediumDepths {
 public:
  /// View and source must outlive it.
  MediumDepths(const View& view, const LightSource& source) : view_(view), source_(source) {
    if (!view.medium.others.empty() && source.atlas)
      volumes_.emplace(view, source.atlas, source.depths);
  }

  LightDepths at(std::size_t volume) const;
  /// Exact, from voxels of a volume of the medium by any camera.
  ExactDepths exact(const View& seen, std::size_t volume) const;
  /// What rays cross of a volume, the first that is seen.
  std::vector<std::vector<Crossed>> crossed(std::size_t volume, const View& seen,
                                            std::span<const glm::dvec2> places) const;
  const LightShare& share() const { return source_.share; }
  std::size_t volumes() const { return 1 + view_.medium.others.size(); }

 private:
  const View& view_;
  const LightSource& source_;
  std::optional<VolumeDepths> volumes_;
};

/// Beams on a view's volume, the first of what is `seen` from it.
using BeamsOn = std::function<std::vector<Beam>(const View& seen, std::size_t volume)>;

/// The beams of the first volume, on each. They must outlive what it returns.
BeamsOn beams_of(const std::vector<Beam>& beams);
/// Beams of the sky from so many directions.
BeamsOn sky_of(int count);

/// Some points of a picture, spread over its rays by what is seen of them in one volume, and the
/// exact light at voxels beside them. From what a computed light misses there it estimates what the
/// picture misses. Rays are drawn by the square of their opacity, by which their light's error
/// counts: a small opaque thing in a thin haze is looked at.
class VolumePilot {
 public:
  /// `view`: its light is still to be computed. The beams are those to compare with, whose methods
  /// do not matter. Depths must outlive the pilot. The members of a team make the same pilot
  /// together, and ask it the same.
  VolumePilot(View view, std::size_t volume, const MediumDepths& depths, const BeamsOn& beams);

  const View& view() const { return view_; }
  /// Mean square of the opacity of the picture's rays. The picture's error grows with its root.
  double coverage() const { return coverage_; }
  /// Voxels whose luminance is compared.
  std::span<const glm::ivec3> voxels() const { return voxels_; }
  /// Cells with attenuation that a ray from a voxel of the medium crosses before it ends at that
  /// transmittance, on average.
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

  View view_;
  std::size_t volume_;
  const MediumDepths& depths_;
  LitLuminance luminance_;
  std::vector<std::vector<Crossed>> cells_;  ///< of the rays that were looked along
  std::vector<Ray> rays_;                    ///< drawn from these
  double coverage_ = 0;
  std::vector<glm::ivec3> voxels_;  ///< points_per_ray of each ray
  std::vector<glm::dvec3> tints_;   ///< factor of the light there, if the function gives colours
  std::vector<glm::dvec3> truth_;   ///< luminance there
};

/// Pilots of all volumes of a medium. What a picture misses in the light of each adds up, at most;
/// the largest errors are rarely in one pixel.
class LightPilot {
 public:
  /// View and depths must outlive it.
  LightPilot(const View& view, const MediumDepths& depths, const BeamsOn& beams);

  const VolumePilot& first() const { return *volumes_.front(); }
  /// What a lit medium misses.
  LightError error(const Medium& lit) const;
  /// What other beams miss, in exact light.
  LightError error(const BeamsOn& beams) const;
  /// VolumePilot::coverage() of all.
  double coverage() const;
  /// The errors of all volumes that are lit, together.
  LightError sum_of(
      const std::function<LightError(const VolumePilot& pilot, std::size_t volume)>& error) const;

 private:
  std::vector<std::unique_ptr<VolumePilot>> volumes_;  ///< null: it is not to be lit
};

}  // namespace psivox
