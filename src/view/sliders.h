#pragma once

#include <glm/vec2.hpp>

namespace psivox::view {

/// A slider of one number. Values outside its ends stay until it is dragged.
bool slide(const char* label, double& value, double least, double most, const char* format);

/// A slider with two ends. Each end is dragged by itself, and both by the bar between them. They
/// stay within `limits`, and apart by a thousandth of these. A label that begins with # is not
/// shown. True if it was moved.
bool slide_ends(const char* label, glm::dvec2& ends, const glm::dvec2& limits);
/// Distance of the first value of a slider with two ends from its left edge [pixels].
double end_margin();

}  // namespace psivox::view
