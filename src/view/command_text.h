#pragma once

#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox::view {

/// Arguments of `psivox render` that draw the scene: the parameters that differ from their
/// defaults, in the table's order.
std::vector<std::string> render_arguments(const Scene& scene, const std::string& output);

/// The same as one line for a shell, quoted.
std::string render_command_line(const Scene& scene, const std::string& output);

}  // namespace psivox::view
