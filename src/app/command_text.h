#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "psivox/medium.h"

// A scene as text: psivox's command line, and the cameras of other renderers.

namespace psivox {

/// Arguments of `psivox render` that draw the scene: its input, the output, and the parameters that
/// differ from their defaults, in the table's order. Nothing is left to a look.
std::vector<std::string> render_arguments(const Scene& scene, const std::string& output);

/// The arguments as one line for a shell, quoted. More options may follow it.
std::string render_command_line(const Scene& scene, const std::string& output);

/// The renderers that camera_lines writes for: `pbrt`, ...; and `json`.
std::vector<std::string> camera_line_formats();

/// The view's camera as lines of a renderer's scene or script, so that its picture of the same
/// volume can be compared with psivox's pixel by pixel; `json` has the whole scene too.
std::string camera_lines(const View& view, const std::string& format);

/// The option that does what an option of that name does in vdb_render, F3D, ParaView, Blender or
/// elsewhere; empty if none is known. It comes before suggestion(): `--samples` resembles
/// `--sampling`.
std::string option_of_concept(std::string_view name);

}  // namespace psivox
