#pragma once

#include <string>
#include <vector>

#include "psivox/medium.h"

namespace psivox {

/// The renderers that camera_lines writes for: `pbrt`, ...; and `json`.
std::vector<std::string> camera_line_formats();

/// The view's camera as lines of a renderer's scene or script, so that its picture of the same
/// volume can be compared with psivox's pixel by pixel; `json` has the whole scene too.
std::string camera_lines(const View& view, const std::string& format);

}  // namespace psivox
