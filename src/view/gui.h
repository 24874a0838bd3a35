#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <string>

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

/// The newest error or message to the user, which the window shows for some seconds.
class Messages {
 public:
  using Clock = std::chrono::steady_clock;

  /// `on_news` is called with each error and message.
  explicit Messages(std::function<void()> on_news) : on_news_(std::move(on_news)) {}

  /// Prints to stderr, too.
  void error(const std::string& text);
  void say(const std::string& text);
  /// Runs `action`; an exception becomes an error.
  void attempt(const std::function<void()>& action);

  /// Empty if a message followed it.
  const std::string& last_error() const { return is_error_ ? text_ : none_; }
  int error_count() const { return error_count_; }
  bool is_error() const { return is_error_; }
  /// The text to show now; may be empty.
  const std::string& shown() const;

 private:
  std::function<void()> on_news_;
  std::string text_, none_;
  bool is_error_ = false;
  int error_count_ = 0;
  Clock::time_point since_{};
};

/// The text of an exception, for a person.
std::string message_of(const std::exception_ptr& error);

}  // namespace psivox::view
