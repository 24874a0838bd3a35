#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "psivox/parameters.h"

// Colours as text.

namespace psivox {

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

}  // namespace psivox
