#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <string>

#include "psivox/camera.h"
#include "psivox/scene.h"

// Widgets that the panels are made of.

namespace psivox::view {

/// A panel while it is drawn; false: it is folded. An exception ends it too. The button that closes
/// it clears `shown`, if there is one.
class Panel {
 public:
  Panel(const char* title, bool* shown, int flags = 0);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
  explicit operator bool() const { return open_; }

 private:
  bool open_;
};

/// A slider of one number. Values outside its ends stay until it is dragged.
bool slide(const char* label, double& value, double least, double most, const char* format);

/// A slider with two ends. Each end is dragged by itself, and both by the bar between them. They
/// stay within `limits`, and apart by a thousandth of these. A label that begins with # is not
/// shown. True if it was moved.
bool slide_ends(const char* label, glm::dvec2& ends, const glm::dvec2& limits);
/// Distance of the first value of a slider with two ends from its left edge [pixels].
double end_margin();

/// What the user of edit_cuts did.
struct CutEdits {
  bool sliced = false;   ///< the slice was moved
  bool turned = false;   ///< and has another normal: the camera may want to face it
  bool clipped = false;  ///< the clip was changed
};

/// Widgets of --slice, under its mode, --clip and --clip-plane: their axes, and sliders over the
/// subject's box. `forward` is the direction of the view, which a plane may take as its normal.
CutEdits edit_cuts(Scene& scene, const Subject& subject, const glm::dvec3& forward);

/// What the window has for the widgets of parameters.
struct ParameterChoices {
  std::span<const std::string> grids;  ///< that the open file offers
  Scene resolved = {};                 ///< with the numbers that `auto` chose
  /// Called with the reason for which a value was refused.
  std::function<void(const std::string& why)> refuse;
};

/// Sets a parameter as the command line does. Throws Error(usage), and leaves the scene, if the
/// rest of it refuses the value.
void set_valid(Scene& scene, const std::string& name, const std::string& text);

/// Makes a section of one group of the table of parameters, without those of the window. True if
/// the scene was changed; it is valid then. A refused parameter keeps its value.
bool edit_group(ParameterGroup group, Scene& scene, const ParameterChoices& choices);

/// Widgets for the parameters named, without headers.
bool edit_parameters(Scene& scene, const ParameterChoices& choices,
                     std::span<const char* const> names);

}  // namespace psivox::view
