#pragma once

#include <glm/vec2.hpp>

#include "psivox/renderer.h"

namespace psivox::view {

/// What of a render the window shows.
enum class ShownLayer { picture, steps, depth };

/// The scene and the options under which a render has that layer.
void ask_for(ShownLayer layer, Scene& scene, RenderOptions& options);

/// Puts the layer into the picture's R G B A as colours of viridis, and returns the values at the
/// two ends; A is 0 where there is no depth. Of the picture itself nothing is changed.
glm::dvec2 show_layer(ShownLayer layer, Image& image);

}  // namespace psivox::view
