#pragma once

#include <cmath>

namespace psivox::image_io {

/// IEC 61966-2-1: the code value of linear light, both in [0, 1].
inline float srgb_from_linear(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

/// IEC 61966-2-1: the linear light of a code value, both in [0, 1].
inline float linear_from_srgb(float code) {
  return code <= 0.04045f ? code / 12.92f : std::pow((code + 0.055f) / 1.055f, 2.4f);
}

}  // namespace psivox::image_io
