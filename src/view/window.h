#pragma once

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

struct WindowOptions {
  std::string title = "psivox";
  glm::ivec2 size{1280, 720};
  bool egl = false;    ///< context by EGL instead of the window system's own API
  bool debug = false;  ///< KHR_debug, see Window::problems
  bool visible = true;
};

/// The pixel of a framebuffer at a place of its window [units of the window system].
glm::dvec2 framebuffer_place(const glm::dvec2& place, const glm::ivec2& window,
                             const glm::ivec2& framebuffer);

/// A window with an OpenGL 4.5 core context, which is current on the main thread.
class Window {
 public:
  /// Throws Error(graphics): no display, no context.
  explicit Window(const WindowOptions& options);
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

}  // namespace psivox::view
