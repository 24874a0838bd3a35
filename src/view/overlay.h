#pragma once

#include <string>

#include "view/viewer.h"

// What the window draws over the picture, and the list of files.

namespace psivox::view {

/// The colours of the values, as the window shows them.
void draw_color_bar(const Viewer& viewer);

/// The world's axes and the volume's box with ticks, as in pictures. Throws Error(usage) for a
/// scene without a camera.
void draw_marks(Viewer& viewer);

/// A panel with the volumes of a folder, which clicks on folders change; empty: the working one.
/// True if a file is chosen.
bool browse(std::string& folder, std::string& file, bool& open);

}  // namespace psivox::view
