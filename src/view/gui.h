#pragma once

#include <array>
#include <span>

#include "view/events.h"
#include "view/window.h"

namespace psivox::view {

/// Dear ImGui in a window, fed with Events so that a test can be the hand.
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

  /// Whether the panels, not the picture, are meant.
  bool takes_pointer() const;
  bool takes_keys() const;
  double scale() const { return scale_; }
  /// Whether panels go to their places: once after another scale.
  bool places_panels() const { return places_panels_; }

 private:
  void set_scale(double scale);

  std::array<bool, 5> down_{}, pressed_{};
  double scale_ = 1;
  bool places_panels_ = true;
};

}  // namespace psivox::view
