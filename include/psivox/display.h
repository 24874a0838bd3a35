#pragma once

#include <cmath>
#include <string>

namespace psivox {

/// A curve from radiance to the light of a display. `none`: radiance 1 is white, and more is cut.
/// `filmic`: Narkowicz's fit of ACES (shaders/math/colour.glsl), which has room above 1.
enum class ToneMap { none, filmic };

/// A view of an OpenColorIO config. It takes the place of the tone map and of sRGB's curve.
struct OcioView {
  std::string config;  ///< file; empty: none
  std::string display;
  std::string view;
  std::string space;  ///< colour space of the picture's light, or a role
  bool operator==(const OcioView&) const = default;
};

/// How sRGB codes show radiance. Pictures of linear radiance ignore it.
struct Display {
  double exposure = 0;  ///< powers of 2
  ToneMap tone_map = ToneMap::none;
  OcioView ocio{};

  double factor() const { return std::exp2(exposure); }
  bool operator==(const Display&) const = default;
};

}  // namespace psivox
