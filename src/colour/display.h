#pragma once

#include "colour/srgb.h"
#include "psivox/display.h"

namespace psivox {

/// Light of the display, 1 for white, of radiance that is multiplied by the exposure's factor.
inline float display_light(float radiance, ToneMap curve) {
  return colour::Math<float>{}.display_light(radiance, static_cast<int>(curve));
}

/// The radiance that the display shows as `light`, below 1.
inline double radiance_of_display(double light, ToneMap curve) {
  return curve == ToneMap::filmic ? colour::Math<double>{}.filmic_inverse(light) : light;
}

}  // namespace psivox
