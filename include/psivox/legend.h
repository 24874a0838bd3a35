#pragma once

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

/// A length of the world, as it is in the plane across the view through the subject's middle.
struct ScaleBar {
  double length = 1;  ///< 1, 2 or 5 times a power of 10 [world units]
  double width = 0;   ///< at most a quarter [picture widths]
};
ScaleBar scale_bar(const View& view);

/// Draws the bar with its length into the lower left corner, on an opaque ground. Returns false if
/// the picture is too small for it. `display`: as for draw_color_bar.
bool draw_scale_bar(Image& image, const ScaleBar& bar, const Display& display);

/// What a picture's file shows beside the picture.
struct Legend {
  std::optional<ColorScale> colors;  ///< --color-bar
  std::optional<ScaleBar> lengths;   ///< --scale-bar
  std::vector<glm::vec3> behind{};   ///< --background environment: radiance by pixels
};

/// The legend that the view's scene asks for.
Legend legend_of(const View& view);

/// Numbers from min to max at round distances, about `count` of them, as the bar's labels.
std::vector<double> round_values(double min, double max, int count);

}  // namespace psivox
