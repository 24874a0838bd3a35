#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "colour/colour.h"
#include "psivox/scene.h"

namespace psivox {

struct Parameter;

/// Files of assets/colors by name: `css.json`.
const std::map<std::string, std::string>& color_data();

/// Converts sRGB codes to linear light and back, channel by channel.
glm::dvec3 linear_from_srgb(const glm::dvec3& code);
glm::dvec3 srgb_from_linear(const glm::dvec3& light);

/// Colours between two sRGB codes, t in [0, 1], as in VTK's vtkColorTransferFunction.
glm::dvec3 mix_lab(const glm::dvec3& a, const glm::dvec3& b, double t);
/// Moreland, "Diverging Color Maps for Scientific Visualization", 2009: Lab in polar form, white in
/// the middle of two saturated colours of different hue.
glm::dvec3 mix_diverging(const glm::dvec3& a, const glm::dvec3& b, double t);
/// `shortest`: hues go round the circle on the shorter side, possibly through red.
glm::dvec3 mix_hsv(const glm::dvec3& a, const glm::dvec3& b, double t, bool shortest);

/// Colour at u, clamped to [0, 1]: linear Rec. 709 radiance, 1 is white. The maps are defined as
/// sRGB codes at knots; between knots the decoded radiance is linear.
glm::dvec3 colormap_color(Colormap map, double u);

/// Places of the map's knots, from 0 to 1.
std::vector<double> colormap_knots(Colormap map);

// Colours as text.

/// The linear colour that #rgb, #rrggbb or a name of CSS stands for: these are sRGB codes.
std::optional<glm::dvec3> named_color(std::string_view text);

/// The three codes of sRGB in R,G,B if all are whole numbers up to 255 and one is above 1; so other
/// programs write colours.
std::optional<glm::ivec3> color_codes(std::string_view text);

/// The linear colour of codes from 0 to 255.
glm::dvec3 color_of_codes(const glm::ivec3& codes);

/// "#ff8000".
std::string hex_text(const glm::ivec3& codes);

/// Whether numbers that look like codes are codes: behind the medium nothing is brighter than
/// white, but lights and luminances are.
bool takes_codes(const Parameter& parameter);

/// Whether one number stands for a grey, and a grey is written as one.
bool takes_grey(const Parameter& parameter);

/// Linear Rec. 709 radiance of a black body, such that 6500 K has luminance (CIE Y) 1. Channels
/// that would be negative, outside the gamut of Rec. 709, are 0: blue below about 1900 K, green too
/// below about 1000 K. The result is 0 up to 200 K, where the radiance is below float32's least
/// normal number. Relative error of X, Y and Z against the integral: 1e-5. May be called from
/// several threads.
glm::dvec3 black_body(double kelvin);

/// Halves (a, b] until `fits(part_begin, part_end)`, into 2^depth parts at most, and appends the
/// ends of the parts.
template <typename Fits>
void append_parts(double a, double b, const Fits& fits, int depth, std::vector<double>& ends) {
  const double middle = 0.5 * (a + b);
  if (depth == 0 || fits(a, b)) {
    ends.push_back(b);
    return;
  }
  append_parts(a, middle, fits, depth - 1, ends);
  append_parts(middle, b, fits, depth - 1, ends);
}

/// Positions in (first, last], ascending to `last`. Between them, straight lines of linear light
/// are near the curve of codes `curve(place)`.
template <typename Curve>
std::vector<double> color_knots(const Curve& curve, double first, double last) {
  const auto fits = [&](double a, double b) {
    const glm::dvec3 from = linear_from_srgb(curve(a)), to = linear_from_srgb(curve(b));
    for (int i = 1; i < 8; ++i) {
      const double t = i / 8.0;
      const glm::dvec3 off =
          glm::abs(srgb_from_linear(glm::mix(from, to, t)) - curve(std::lerp(a, b, t)));
      if (std::max({off.r, off.g, off.b}) > half_code<double>) return false;
    }
    return true;
  };
  std::vector<double> ends;
  append_parts(first, last, fits, 9, ends);
  return ends;
}

}  // namespace psivox
