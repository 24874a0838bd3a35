#pragma once

#include <string>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// Arguments of `psivox render` that draw the scene: its input, the output, and the parameters that
/// differ from their defaults, in the table's order. Nothing is left to a look.
std::vector<std::string> render_arguments(const Scene& scene, const std::string& output);

/// `text` as one word of a shell, between single quotes.
std::string shell_word(const std::string& text);

/// The arguments as one line for a shell, quoted. More options may follow it.
std::string render_command_line(const Scene& scene, const std::string& output);

}  // namespace psivox
