#pragma once

#include <algorithm>
#include <cmath>

// shaders/math/colour.glsl as C++, in float and in double.

namespace psivox {

namespace colour {

using std::min;
using std::pow;
using std::sqrt;

template <typename Real>
struct Math {
  using real = Real;
#include "math/colour.glsl"
};

}  // namespace colour

inline float srgb_from_linear(float light) { return colour::Math<float>{}.srgb_from_linear(light); }
inline double srgb_from_linear(double light) {
  return colour::Math<double>{}.srgb_from_linear(light);
}
inline float linear_from_srgb(float code) { return colour::Math<float>{}.linear_from_srgb(code); }
inline double linear_from_srgb(double code) {
  return colour::Math<double>{}.linear_from_srgb(code);
}

/// Half a step between codes of 8 bits: less is no visible difference.
template <typename Real>
inline constexpr Real half_code = Real(0.5) / 255;

}  // namespace psivox
