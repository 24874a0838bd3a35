#pragma once

#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox::view {

/// Arguments of `psivox render` that draw the scene: what differs from the defaults, in the table's
/// order.
std::vector<std::string> render_arguments(const Scene& scene, const std::string& output);

/// The same as a line for a shell, quoted where it must be.
std::string render_command_line(const Scene& scene, const std::string& output);

}  // namespace psivox::view
