#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "draw/light_source.h"

namespace psivox {

/// What a picture misses in its light.
struct LightError {
  double rms = 0;  ///< over the pixels and R G B A
  double max = 0;  ///< of one channel of a ray

  LightError operator*(double factor) const { return {rms * factor, max * factor}; }
};

/// The error of independent parts of the light together.
LightError sum(const LightError& a, const LightError& b);

/// Beams on a view's volume, the first of what is `seen` from it.
using BeamsOn = std::function<std::vector<Beam>(const View& seen, std::size_t volume)>;

/// The beams of the first volume, on each. They must outlive what it returns.
BeamsOn beams_of(const std::vector<Beam>& beams);
/// Beams of the sky from so many directions.
BeamsOn sky_of(int count);

void set_method(std::vector<Beam>& beams, const LightMethod& method);

/// Some points of a picture, spread over its rays by what is seen of them in each volume, and the
/// exact light at voxels beside them. From what a computed light misses there it estimates what the
/// picture misses. Rays are drawn by the square of their opacity, by which their light's error
/// counts: a small opaque thing in a thin haze is looked at. What is missed in the light of several
/// volumes adds up, at most; the largest errors are rarely in one pixel.
class LightPilot {
 public:
  /// `view`: its light is still to be computed. The beams are those to compare with, whose methods
  /// do not matter. Depths must outlive the pilot. The members of a team make the same pilot
  /// together, and ask it the same.
  LightPilot(const View& view, const MediumDepths& depths, BeamsOn beams);
  ~LightPilot();

  /// What the picture misses in a lit medium. The maximum is of these rays, whose points' own noise
  /// enlarges it.
  LightError error(const Medium& lit) const;
  /// In the light of other beams, exactly.
  LightError error(const BeamsOn& beams) const;
  /// In the exact light of another pilot's beams, at the same points: of the same view, and as many
  /// rays.
  LightError error(const LightPilot& other) const;
  /// In the pilot's own beams by a method.
  LightError error(const LightMethod& method) const;

  /// Mean square of the opacity of the picture's rays. The error of its light grows with its root.
  double coverage() const;
  /// The transmittance behind which no more than `light` of a beam arrives.
  double transmittance(double light) const;
  /// Cells with attenuation that a ray from a voxel of the first volume crosses before it ends at
  /// that transmittance, on average.
  double mean_cells(double termination) const;

 private:
  struct Volume;
  LightError sum_of(const std::function<LightError(const Volume& volume)>& error) const;

  const MediumDepths& depths_;
  BeamsOn beams_;
  std::vector<std::unique_ptr<Volume>> volumes_;  ///< that are lit
};

}  // namespace psivox
