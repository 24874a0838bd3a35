#pragma once

#include <cmath>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "medium/backdrop.h"
#include "plan/method.h"

namespace psivox {

/// Contribution of float32 arithmetic to a picture's RMS error (docs/method.md).
inline constexpr double arithmetic_error = 4e-7;

/// A pixel of the picture, and what its ray shows.
struct SeenPixel {
  glm::ivec2 pixel{0};
  glm::vec4 picture{0};  ///< R G B A
};

/// What a method misses on the first of the pilot's rays.
struct RayErrors {
  std::size_t rays = 0, all_rays = 0;       ///< marched, and of the pilot
  double squares = 0;                       ///< sum over R G B A of the squared errors
  double max = 0;                           ///< of a channel
  std::size_t worst = 0;                    ///< the ray that has it
  double samples = 0;                       ///< field look-ups
  double exact_samples = 0, all_exact = 0;  ///< the truth's, on these rays and on all

  double rms() const { return rms_of(rays); }
  /// If the other rays miss nothing.
  double least_rms() const { return rms_of(all_rays); }
  /// Look-ups per ray, expected of all: rays differ less in their ratio to the truth's look-ups.
  double samples_per_ray() const {
    return exact_samples > 0 ? samples * (all_exact / exact_samples) / double(all_rays)
                             : samples / double(rays);
  }

 private:
  double rms_of(std::size_t count) const {
    return std::hypot(std::sqrt(squares / (4 * double(count))), arithmetic_error);
  }
};

/// Some hundred of a picture's rays with the truth along them, on which methods are tried. Rays are
/// marched in double, in an order whose every beginning is spread evenly over the picture. The one
/// that a method misses most comes first afterwards.
class Pilot {
 public:
  /// Whether more rays shall be marched.
  using GoOn = std::function<bool(const RayErrors& errors)>;

  /// `view` has the transmittance at which the picture's rays end; the truth's end far later.
  /// `behind`: the picture's. `progress` is called with 0, often: it may throw.
  Pilot(const View& view, const Backdrop& behind, const MediumAtlas& atlas,
        const Progress& progress);

  /// The pilot's picture, marched exactly.
  const Image& truth() const { return truth_; }
  /// What is behind its pixels.
  const Backdrop& behind() const { return behind_; }
  /// What the exact method misses if its rays end as the picture's do.
  const RayErrors& exact_errors() const { return exact_errors_; }
  /// Pixels of the picture that are brighter than what the pilot's rays let expect.
  const std::vector<SeenPixel>& unmet() const { return unmet_; }
  /// Rays that show anything.
  int telling_rays() const;
  /// Largest radiance that is to be expected of a ray, without what is behind the medium.
  double brightest() const;

  /// Marches rays by a method. `codes`: see PixelMarch.
  RayErrors march(const MethodView& marched, const MediumAtlas& atlas, const Progress& progress,
                  const GoOn& go_on, const BrickCodes* codes = nullptr);

  /// Field look-ups of all that was marched.
  std::uint64_t all_samples() const { return all_samples_; }

 private:
  void add(RayErrors& errors, const glm::ivec2& pixel, const MarchedRay& ray) const;

  Image truth_;
  Backdrop behind_;
  std::vector<glm::ivec2> pixels_;     ///< in order
  std::vector<double> exact_samples_;  ///< of the truth, by pixels
  RayErrors exact_errors_;
  std::vector<SeenPixel> unmet_;
  std::uint64_t all_samples_ = 0;
};

/// Columns and rows of about `count` rays, spread over a picture.
glm::ivec2 rays_over(const glm::ivec2& picture, double count);

/// The view of the pilot's rays: some hundreds of the picture's, spread over it.
View pilot_view(const View& view);

/// Pixels whose rays meet what may be bright: of the voxels that emit most, at most one in each of
/// 64 parts of the picture, and 64 of each further volume.
std::vector<glm::ivec2> glowing_pixels(const View& view, const MediumAtlas& atlas);

}  // namespace psivox
