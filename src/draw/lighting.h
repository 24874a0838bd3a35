#pragma once

#include <optional>

#include "march/light_pilot.h"
#include "march/marcher.h"

namespace psivox {

/// What a picture asks of its light.
struct LightNeed {
  bool exact = false;
  double rms = 0;  ///< largest error, RMS over the picture and R G B A; 0: any light will do
};

/// How processes that share a medium know their light's error.
struct SharedLight {
  LightShare share{};
  /// Exact depths through the whole; unset: it is all here.
  std::function<LightPilot::Depths(const View& view)> exact_depths{};
};

/// The light of a medium, as far as it is computed, for pictures by several cameras.
class Lighting {
 public:
  /// `view` has the medium without its light. `bricks`: where light is asked for, if not wherever
  /// it is seen.
  explicit Lighting(const View& view, const std::optional<Box>& bricks = {})
      : view_(view), bricks_(bricks) {}

  /// To be called before the first light, where others have parts of the medium. All then ask the
  /// same of their light together.
  void share(SharedLight shared) { shared_ = std::move(shared); }

  /// Whether the light that is there serves the picture of a camera. Sets error(). `atlas` is null
  /// where there is none of the whole.
  bool serves(const Camera& camera, const Scene& scene, const MediumAtlas* atlas, LightNeed need);

  /// Computes the light for it. The marcher holds the atlas, for exact filtering.
  void compute(Marcher& marcher, const Camera& camera, const Scene& scene, const MediumAtlas* atlas,
               LightNeed need, const Progress& progress);

  /// The medium in exact light, for comparisons.
  Medium exact_medium(const Camera& camera, const Scene& scene, const MediumAtlas& atlas) const;

  /// Forgets the light, so that it takes no memory beside the next.
  void forget() { medium_.reset(); }

  /// The medium without its light.
  const Medium& dark() const { return view_.medium; }
  /// The medium with the light.
  const Medium& medium() const { return *medium_; }
  /// Estimated error of the light in the last picture asked for; 0: exact.
  const LightError& error() const { return error_; }
  DrawnLight description() const;

 private:
  View seen(const Camera& camera, const Scene& scene) const;
  /// Exact optical depths: by the atlas, or by the grids where there is none of the whole.
  LightPilot::Depths exact_depths(const View& view, const MediumAtlas* atlas) const;
  void replace(Marcher& marcher, const Camera& camera, const Scene& scene, const MediumAtlas* atlas,
               LightNeed need, const Progress& progress);
  /// The view by which methods are chosen. Its camera is the same for all pictures of a medium, so
  /// that a picture does not depend on those that were drawn before it, unless the light itself
  /// depends on the camera.
  View typical_view(const View& view) const;
  void add_sky(const View& view, int count);
  /// Computes medium_ from beams_.
  void sum_up(const View& view, const LightDepths& depths, const Progress& progress);
  /// Computes the light of the beams that are there within an RMS, and finds their method.
  void settle_lights(const View& view, const MediumAtlas* atlas, const LightDepths& depths,
                     double rms, const Progress& progress);

  View view_;
  std::optional<Box> bricks_;
  SharedLight shared_;
  std::vector<glm::ivec3> blocks_;  ///< visible; empty until they are needed
  std::optional<Medium> medium_;
  std::vector<Beam> beams_;
  Camera camera_;
  LightError error_;
  LightError sky_error_;  ///< what the sky's directions miss
};

}  // namespace psivox
