#pragma once

#include <string>

namespace psivox::view {

class Viewer;

/// Which panels are open, and what is typed into them.
struct Panels {
  bool scene = true, transfer = false, help = false;
  std::string open_path;
  std::string picture_path = "picture.exr", scene_path = "scene.json";
  std::string picture_size;  ///< WxH of saved pictures; empty: the window's
};

/// Draws what the window shows beside the picture, and does what its widgets ask for.
void draw_panels(Viewer& viewer);

}  // namespace psivox::view
