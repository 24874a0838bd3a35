#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "psivox/image.h"
#include "psivox/medium.h"

namespace psivox {

/// The colours of a view's values.
struct ColorScale {
  std::string title;               ///< the grid's name
  double min = 0, max = 1;         ///< values of the first and the last colour
  std::vector<glm::dvec3> colors;  ///< luminance, at equal distances of the value
};

/// Unset if no colour map, transfer function or maximum gives values a colour.
std::optional<ColorScale> color_scale(const View& view);

/// Draws the scale with numbers into that strip, on an opaque ground. Returns false if the picture
/// is too small for it. `display`: how the file will show values, so that text is white there.
bool draw_color_bar(Image& image, const ColorScale& scale, const Display& display);

/// Numbers from min to max at round distances, about `count` of them, as the bar's labels.
std::vector<double> round_values(double min, double max, int count);

}  // namespace psivox
