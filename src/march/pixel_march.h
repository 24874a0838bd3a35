#pragma once

#include <glm/vec4.hpp>
#include <memory>
#include <span>

#include "march/marcher.h"

namespace psivox {

struct MarchSetup;

/// What the ray through a pixel's centre shows.
struct MarchedRay {
  glm::vec4 picture{0};  ///< R G B A
  double samples = 0;    ///< field look-ups
};

/// Marches rays through the centres of single pixels, in double. The atlas must outlive it.
class PixelMarch {
 public:
  PixelMarch(const View& view, const MediumAtlas& atlas, const BrickSteps& brick_steps = {});

  /// `progress` is called on this thread, often; it may throw.
  void march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
             const Progress& progress) const;
  /// Also sets `ended`: what `sooner` marches, the same view but that rays end at a larger
  /// transmittance. A ray is marched once.
  void march(std::span<const glm::ivec2> pixels, std::span<MarchedRay> rays,
             const PixelMarch& sooner, std::span<MarchedRay> ended, const Progress& progress) const;

 private:
  std::shared_ptr<const MarchSetup> setup_;
  const MediumAtlas* atlas_;
};

}  // namespace psivox
