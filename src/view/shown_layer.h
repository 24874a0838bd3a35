#pragma once

#include <glm/vec2.hpp>
#include <span>

#include "psivox/draw.h"

namespace psivox::view {

/// The layer of a render that the window shows.
enum class ShownLayer { picture, steps, depth, error };

/// Their names, as --aov takes them.
inline constexpr const char* shown_layers[] = {"picture", "steps", "depth", "error"};

/// Asks for that layer of the wish's scene.
void ask_for(ShownLayer layer, Wish& wish);

/// Writes the layer into R G B A of the pictures as colours of viridis. Returns the values at the
/// two ends, which all pictures share. A is 0 where a ray has no depth. A picture without the layer
/// does not change.
glm::dvec2 show_layer(ShownLayer layer, std::span<Image> images);

}  // namespace psivox::view
