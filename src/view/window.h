#pragma once

#include <array>
#include <chrono>
#include <exception>
#include <functional>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "psivox/image.h"

struct GLFWwindow;

namespace psivox::view {

/// An action of the user on the window, or of a test in its place. Codes are GLFW's. Places are
/// pixels of the framebuffer from the top left.
struct Event {
  enum class Kind { move, button, wheel, key, text, drop, close, scale, refresh };
  Kind kind = Kind::move;
  /// Of the pointer; of a wheel: its notches; x of a scale: of text from now on.
  glm::dvec2 place{0};
  int code = 0;  ///< button, key or character
  bool down = false;
  int modifiers = 0;
  std::vector<std::string> files{};  ///< dropped
};

/// The pixel of a framebuffer at a place of its window [units of the window system].
glm::dvec2 framebuffer_place(const glm::dvec2& place, const glm::ivec2& window,
                             const glm::ivec2& framebuffer);

/// A window with an OpenGL 4.5 core context, which is current on the main thread.
class Window {
 public:
  /// `egl`: its context by EGL instead of the window system's own API. `debug`: KHR_debug, see
  /// problems(). Throws Error(graphics): no display, no context.
  Window(const glm::ivec2& size, bool egl, bool debug);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Waits for events, at most `seconds`, and returns them.
  std::vector<Event> wait(double seconds);
  /// Adds an event as if the user had caused it.
  void post(Event event);
  /// Ends a wait; any thread may call it.
  static void wake();

  glm::ivec2 size() const;  ///< of the framebuffer [pixels]; 0 if it is minimised
  void hide();
  void resize(const glm::ivec2& size);
  double scale() const;  ///< of text: 2 on a display of twice the usual density
  void set_title(const std::string& title);
  void set_clipboard(const std::string& text);
  std::string clipboard() const;
  void swap();

  /// The picture that the next swap() shows, decoded from sRGB to linear.
  Image grab() const;
  /// Messages of KHR_debug and of glGetError since the last call.
  std::vector<std::string> problems();

 private:
  static void on_glfw_error(int code, const char* text);
  glm::dvec2 pixel(double x, double y) const;
  void listen();

  GLFWwindow* window_ = nullptr;
  std::vector<Event> events_;
  std::vector<std::string> problems_;
};

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
  /// Whether a hand is on a widget.
  bool editing() const;
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
