#pragma once

#include <optional>
#include <span>

#include "draw/light_pilot.h"
#include "march/marcher.h"
#include "psivox/draw.h"

namespace psivox {

/// What a picture asks of its light.
struct LightNeed {
  bool exact = false;
  double rms = 0;  ///< largest error, RMS over the picture and R G B A; 0: any light will do
};

/// Part of a scene's tolerance that its light may use up. The march has what is left, in
/// quadrature: beside a sky, which takes far longer, less.
double light_share(const Scene& scene);

/// What a wish for a picture of the scene asks of its light.
LightNeed light_need(const Marcher& marcher, const Scene& scene, const Wish& wish);

/// The light of a medium, as far as it is computed, for pictures by several cameras.
class Lighting {
 public:
  /// Whether the light that is there serves the picture of a dark view's camera. Sets error(). All
  /// processes that draw the picture ask it and compute() together.
  bool serves(const View& view, const LightSource& source, LightNeed need);

  /// Computes the light for it in some bricks, as far as they are seen.
  void compute(const View& view, const Box& bricks, const LightSource& source, LightNeed need,
               const Progress& progress);

  /// The medium of a dark view in exact light, for comparisons along some rays: the rest of it may
  /// be dark.
  Medium exact_medium(const View& view, const MediumAtlas& atlas, std::span<const WorldRay> rays,
                      const Progress& progress) const;

  /// Forgets the light, so that it takes no memory beside the next.
  void forget() { medium_.reset(); }

  /// The medium with the light; unset: there is none.
  std::optional<Medium>& medium() { return medium_; }
  /// Estimated error of the light in the last picture asked for; 0: exact.
  const LightError& error() const { return error_; }
  DrawnLight description() const;

 private:
  void replace(const View& view, const LightSource& source, LightNeed need,
               const Progress& progress);
  /// The view by which methods are chosen. Its camera is the same for all pictures of a medium, so
  /// that a picture does not depend on those that were drawn before it, unless the light itself
  /// depends on the camera.
  View typical_view(const View& view) const;
  /// By how much more a picture misses that shows more of what the sky's directions miss.
  double closer(double coverage) const;
  void add_sky(const View& view, int count);
  /// Computes medium_ from beams_.
  void sum_up(const View& view, const MediumDepths& depths, const Progress& progress);
  /// Computes the light of the beams that are there within an RMS, and finds their method.
  void settle_lights(const View& view, const MediumDepths& depths, double rms,
                     const Progress& progress);

  std::vector<glm::ivec3> blocks_;  ///< whose light is seen
  std::optional<Medium> medium_;
  std::vector<Beam> beams_;  ///< of the first volume
  Camera camera_;
  bool coarse_ = false;  ///< computed for a preview
  LightError error_;
  LightError sky_error_;     ///< what the sky misses
  double sky_coverage_ = 0;  ///< of the picture that misses that: LightPilot::coverage()
};

}  // namespace psivox
