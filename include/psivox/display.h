#pragma once

#include <cmath>

namespace psivox {

/// A curve from radiance to the light of a display. `none`: radiance 1 is white, and more is cut.
/// `filmic`: Narkowicz's fit of ACES (shaders/math/colour.glsl), which has room above 1.
enum class ToneMap { none, filmic };

/// How sRGB codes show radiance. Pictures of linear radiance ignore it.
struct Display {
  double exposure = 0;  ///< powers of 2
  ToneMap tone_map = ToneMap::none;

  double factor() const { return std::exp2(exposure); }
  bool operator==(const Display&) const = default;
};

}  // namespace psivox
