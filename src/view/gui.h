#pragma once

#include <array>
#include <span>

#include "view/events.h"
#include "view/window.h"

namespace psivox::view {

/// Dear ImGui in a window. It takes Events, so that a test can take the place of the user.
class Gui {
 public:
  explicit Gui(Window& window);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  void feed(const Event& event);
  void begin_frame(const glm::ivec2& size, double seconds);
  /// Draws into the window.
  void end_frame();

  /// Whether the pointer or the keyboard is for the panels, not for the picture.
  bool takes_pointer() const;
  bool takes_keys() const;
  double scale() const { return scale_; }
  /// Whether panels go to their places in this frame: the first after a change of the scale.
  bool places_panels() const { return places_panels_; }

 private:
  void set_scale(double scale);

  std::array<bool, 5> down_{}, pressed_{};
  double scale_ = 1;
  bool places_panels_ = true;
};

}  // namespace psivox::view
