#include "view/window.h"

#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <glm/common.hpp>
#include <utility>

#include "colour/colour.h"
#include "gl/gl_renderer.h"
#include "psivox/error.h"

namespace psivox::view {
namespace {

std::string& last_glfw_error() {
  static std::string text;
  return text;
}

Window& window_of(GLFWwindow* window) {
  return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

/// GLFW's modifiers by the keys that are down.
int modifiers_of(GLFWwindow* window) {
  const auto held = [&](int left, int right, int modifier) {
    return glfwGetKey(window, left) || glfwGetKey(window, right) ? modifier : 0;
  };
  return held(GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT, GLFW_MOD_SHIFT) |
         held(GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL, GLFW_MOD_CONTROL) |
         held(GLFW_KEY_LEFT_ALT, GLFW_KEY_RIGHT_ALT, GLFW_MOD_ALT);
}

constexpr int widest = 16384;  // a larger window makes X11 end the program

constexpr const char* advice =
    "; psivox render draws the same picture to a file and needs no display";

float linear_of(unsigned char code) { return float(linear_from_srgb(code / 255.0)); }

}  // namespace

glm::dvec2 framebuffer_place(const glm::dvec2& place, const glm::ivec2& window,
                             const glm::ivec2& framebuffer) {
  return place * glm::dvec2(framebuffer) / glm::dvec2(glm::max(window, glm::ivec2(1)));
}

void Window::on_glfw_error(int, const char* text) { last_glfw_error() = text; }

Window::Window(const glm::ivec2& size, bool egl, bool debug) {
  gl::find_bundled_driver();
  glfwSetErrorCallback(on_glfw_error);
  if (!glfwInit())
    throw Error(ExitCode::graphics, "no display for a window: " + last_glfw_error() + advice);
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, egl ? GLFW_EGL_CONTEXT_API : GLFW_NATIVE_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  const glm::ivec2 shown = glm::clamp(size, 1, widest);
  window_ = glfwCreateWindow(shown.x, shown.y, "psivox", nullptr, nullptr);
  if (!window_) {
    const std::string why = last_glfw_error();
    glfwTerminate();
    throw Error(ExitCode::graphics, "no window with OpenGL 4.5: " + why + advice);
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  if (debug) gl::collect_faults(problems_);
  listen();
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

glm::dvec2 Window::pixel(double x, double y) const {
  glm::ivec2 window{0};
  glfwGetWindowSize(window_, &window.x, &window.y);
  return framebuffer_place({x, y}, window, size());
}

void Window::listen() {
  using Kind = Event::Kind;
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    Window& self = window_of(w);
    self.events_.push_back({Kind::move, self.pixel(x, y)});
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int modifiers) {
    Window& self = window_of(w);
    double x = 0, y = 0;
    glfwGetCursorPos(w, &x, &y);
    self.events_.push_back(
        {Kind::button, self.pixel(x, y), button, action == GLFW_PRESS, modifiers});
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double x, double y) {
    window_of(w).events_.push_back({Kind::wheel, {x, y}});
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
    // X11's modifiers are those before a modifier's own press or release
    window_of(w).events_.push_back({Kind::key, {}, key, action != GLFW_RELEASE, modifiers_of(w)});
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned character) {
    window_of(w).events_.push_back({Kind::text, {}, int(character)});
  });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    window_of(w).events_.push_back({Kind::drop, {}, 0, false, 0, {paths, paths + count}});
  });
  glfwSetWindowCloseCallback(window_,
                             [](GLFWwindow* w) { window_of(w).events_.push_back({Kind::close}); });
  glfwSetWindowContentScaleCallback(window_, [](GLFWwindow* w, float, float) {
    Window& self = window_of(w);
    self.events_.push_back({Kind::scale, {self.scale(), 0}});
  });
  glfwSetWindowRefreshCallback(
      window_, [](GLFWwindow* w) { window_of(w).events_.push_back({Kind::refresh}); });
}

std::vector<Event> Window::wait(double seconds) {
  if (seconds > 0 && events_.empty())
    glfwWaitEventsTimeout(seconds);  // posted events do not wait
  else
    glfwPollEvents();
  return std::exchange(events_, {});
}

void Window::post(Event event) { events_.push_back(std::move(event)); }

void Window::wake() { glfwPostEmptyEvent(); }

glm::ivec2 Window::size() const {
  if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return {0, 0};
  glm::ivec2 pixels{0};
  glfwGetFramebufferSize(window_, &pixels.x, &pixels.y);
  return pixels;
}

void Window::hide() { glfwHideWindow(window_); }

void Window::resize(const glm::ivec2& size) { glfwSetWindowSize(window_, size.x, size.y); }

double Window::scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return std::clamp(double(std::max(x, y)), 1.0, 4.0);
}

void Window::set_title(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

void Window::set_clipboard(const std::string& text) {
  glfwSetClipboardString(window_, text.c_str());
}

std::string Window::clipboard() const {
  const char* text = glfwGetClipboardString(window_);
  return text ? text : "";
}

void Window::swap() { glfwSwapBuffers(window_); }

Image Window::grab() const {
  const glm::ivec2 pixels = size();
  Image image = rgba_image(pixels.x, pixels.y, 1);
  const auto width = std::size_t(pixels.x), height = std::size_t(pixels.y);
  std::vector<unsigned char> codes(width * height * 4);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glReadBuffer(GL_BACK);
  glReadPixels(0, 0, pixels.x, pixels.y, GL_RGBA, GL_UNSIGNED_BYTE, codes.data());
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < 4 * width; ++x)
      if (x % 4 != 3)
        image.rgba()[y * 4 * width + x] = linear_of(codes[(height - 1 - y) * 4 * width + x]);
  return image;
}

std::vector<std::string> Window::problems() {
  for (GLenum code = glGetError(); code != GL_NO_ERROR; code = glGetError())
    problems_.push_back("glGetError " + std::to_string(code));
  return std::exchange(problems_, {});
}

}  // namespace psivox::view
