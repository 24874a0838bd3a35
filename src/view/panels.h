#pragma once

#include <string>

namespace psivox::view {

class Viewer;

/// Which panels are open, and the text typed into them.
struct Panels {
  bool scene = true, transfer = false, help = false;
  bool slices = false;  ///< the scene was a slice when the panels were last drawn
  std::string open_path;
  std::string picture_path = "picture.exr", scene_path = "scene.json";
  std::string picture_size;  ///< WxH of saved pictures; empty: the window's
};

/// Draws everything but the picture, and carries out the commands of its widgets.
void draw_panels(Viewer& viewer);

}  // namespace psivox::view
