#pragma once

#include <glm/vec2.hpp>
#include <span>

#include "psivox/draw.h"

namespace psivox::view {

/// What of a render the window shows.
enum class ShownLayer { picture, steps, depth, error };

/// Their names, in that order: those of --aov.
inline constexpr const char* shown_layers[] = {"picture", "steps", "depth", "error"};

/// Asks for that layer of the wish's scene.
void ask_for(ShownLayer layer, Wish& wish);

/// Puts the layer into the pictures' R G B A as colours of viridis, and returns the values at the
/// two ends, the same for all; A is 0 where there is no depth. A picture without the layer stays.
glm::dvec2 show_layer(ShownLayer layer, std::span<Image> images);

}  // namespace psivox::view
