#pragma once

#include <epoxy/egl.h>

#include <string>
#include <vector>

#include "psivox/marcher.h"

namespace psivox::gl {

/// A 4.5 core context without a window, current on the thread that made it until release().
class EglContext {
 public:
  /// Tries `options.device`, or every device in turn, hardware before software; then the
  /// surfaceless platform. Throws Error(graphics) that says what to install.
  explicit EglContext(const ContextOptions& options);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes it current on the calling thread; it must not be current on another.
  void make_current() const;
  /// Makes no context current on the calling thread, so that another may take this one.
  void release() const;
  std::string renderer() const;
  std::string version() const;

  /// Throws DeviceFull if the device's memory is full, Error(graphics) if the driver has reset the
  /// GPU. Throws Error(graphics) with the first KHR_debug message since the last call, if there was
  /// one (contexts made with ContextOptions::debug only), or with glGetError's.
  void check(const std::string& doing) const;

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
  mutable std::vector<std::string> faults_;  ///< see collect_faults

  /// Why a display has no context for us. Of several displays', the one of the latest stage tells
  /// most.
  struct Obstacle {
    int stage;
    std::string what;
  };
  /// Throws an Obstacle.
  void open(EGLDisplay display, bool debug);
  /// What the display has in place of an OpenGL 4.5 core context.
  std::string offered(EGLConfig config);
  void close();
};

}  // namespace psivox::gl
