#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "colour/colour.h"
#include "psivox/image.h"

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

namespace psivox::image_io {

/// `value` cut to [0, 1]; 0 for NaN.
inline float clamped(float value) { return value > 0 ? (value < 1 ? value : 1.0f) : 0.0f; }

/// Premultiplied R G B A as sRGB codes that fill `Code`, an unsigned type. With four channels,
/// colour is divided by alpha; alpha stays linear. With three, the picture stands over black.
/// Colour is exposed and tone mapped as `display` says, cut to [0, 1] and encoded; or a view of
/// OpenColorIO encodes what is exposed.
///
/// Light above alpha (a glow without opacity) is cut to alpha, and lost where alpha is 0: raising
/// alpha instead would save it over black, but make a glow hide what is behind it.
template <typename Code>
std::vector<Code> srgb_codes(std::span<const float> rgba, std::size_t channels,
                             const Display& display) {
  const auto quantised = [](float value) {
    return Code(value * std::numeric_limits<Code>::max() + 0.5f);
  };
  const auto factor = float(display.factor());
  const auto alpha_at = [&](std::size_t i) { return channels == 4 ? clamped(rgba[i + 3]) : 1; };
  const bool by_view = !display.ocio.config.empty();
  std::vector<float> viewed;  // R G B
  if (by_view) viewed.reserve(rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < rgba.size() && by_view; ++i)
    if (const float alpha = alpha_at(i / 4 * 4); i % 4 != 3)
      viewed.push_back(alpha > 0 ? factor * rgba[i] / alpha : 0);
  if (by_view) show_by(display.ocio, viewed);
  std::vector<Code> codes(rgba.size() / 4 * channels);
  const auto encode = [&](std::size_t pixel) {
    const std::size_t i = 4 * pixel, to = channels * pixel;
    const float alpha = alpha_at(i);
    for (std::size_t c = 0; c < 3 && alpha > 0; ++c) {
      const float code = by_view ? viewed[i / 4 * 3 + c]
                                 : srgb_from_linear(clamped(display_light(
                                       factor * rgba[i + c] / alpha, display.tone_map)));
      codes[to + c] = quantised(clamped(code));
    }
    if (channels == 4) codes[to + 3] = quantised(alpha);
  };
  tbb::parallel_for(std::size_t{0}, rgba.size() / 4, encode);
  return codes;
}

}  // namespace psivox::image_io
