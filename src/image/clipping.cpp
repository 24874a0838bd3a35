// What sRGB codes cannot show of a picture's light.

#include <algorithm>
#include <cmath>
#include <vector>

#include "colour/display.h"
#include "format.h"
#include "psivox/image.h"
#include "srgb_codes.h"

namespace psivox {
namespace {

using image_io::half_code;

float brightest(const float* rgba) { return std::max({rgba[0], rgba[1], rgba[2]}); }

}  // namespace

Clipping clipping(const Image& image, const std::filesystem::path& path,
                  const WriteOptions& options) {
  Clipping result;
  if (!holds_codes(path, options)) return result;
  const bool has_alpha = image_io::facts_of(image_io::format_from_extension(path)).alpha;
  const auto factor = static_cast<float>(options.display.factor());
  const auto shown = [&](float radiance) {
    return display_light(factor * radiance, options.display.tone_map);
  };
  const auto rgba = image.rgba();
  double light = 0, lost = 0;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float alpha = has_alpha ? image_io::clamped(rgba[i + 3]) : 1;
    const float most = brightest(&rgba[i]);
    result.clipped += shown(most) > 1 + half_code;
    const bool glows = most > alpha + half_code;
    double missing = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const float wanted = image_io::clamped(shown(rgba[i + c]));
      light += double(wanted);
      if (!glows) continue;
      const float over_black =
          alpha > 0 ? alpha * image_io::clamped(shown(rgba[i + c] / alpha)) : 0;
      if (wanted > over_black + half_code) missing += double(wanted - over_black);
    }
    lost += missing;
    result.cut += missing > 0;
  }
  if (light > 0) result.lost = lost / light;
  return result;
}

double auto_exposure(const Image& image, ToneMap tone_map) {
  constexpr double percentile = 0.99, target = 0.95;
  const auto rgba = image.rgba();
  std::vector<float> lights;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const float light = brightest(&rgba[i]);
    if (light > 0 && std::isfinite(light)) lights.push_back(light);
  }
  if (lights.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(percentile * double(lights.size() - 1));
  std::nth_element(lights.begin(), lights.begin() + at, lights.end());
  const double bright = double(lights[static_cast<std::size_t>(at)]);
  return std::round(100 * std::log2(radiance_of_display(target, tone_map) / bright)) / 100;
}

}  // namespace psivox
