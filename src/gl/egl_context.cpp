#include "gl/egl_context.h"

#include <dlfcn.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/loaded_module.h"
#include "gl/gl_renderer.h"

namespace psivox::gl {
namespace {

constexpr const char* install_advice =
    "; install an OpenGL driver with EGL, such as Debian's libegl1 and libgl1-mesa-dri";

constexpr const char* memory_advice =
    "--lod 1 takes an eighth of it, and a smaller --memory-limit draws it in parts";

bool has_extension(const char* extensions, const char* name) {
  if (!extensions) return false;
  const std::size_t length = std::strlen(name);
  for (const char* at = extensions; (at = std::strstr(at, name)); at += length)
    if ((at == extensions || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
      return true;
  return false;
}

bool has_library(const char* name) { return dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr; }

/// libepoxy ends the process where it does not find them.
void require_libraries() {
  if (!has_library("libEGL.so.1"))
    throw Error(ExitCode::graphics, std::string("libEGL.so.1 is missing") + install_advice);
  if (!has_library("libOpenGL.so.0") && !has_library("libGL.so.1"))
    throw Error(ExitCode::graphics, "libOpenGL.so.0 is missing; install it (Debian: libopengl0)");
}

const char* client_extensions() { return eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS); }

/// A display to try, and its index among the EGL devices (-1: none of them).
struct Candidate {
  EGLDisplay display;
  int device;
  bool software;
};

std::vector<Candidate> device_displays() {
  require_libraries();
  std::vector<Candidate> result;
  const char* client = client_extensions();
  if (!has_extension(client, "EGL_EXT_platform_device") ||
      !(has_extension(client, "EGL_EXT_device_enumeration") ||
        has_extension(client, "EGL_EXT_device_base")))
    return result;
  EGLDeviceEXT devices[64];
  EGLint count = 0;
  if (!eglQueryDevicesEXT(64, devices, &count)) return result;
  for (int i = 0; i < count; ++i) {
    const char* own = has_extension(client, "EGL_EXT_device_query") ||
                              has_extension(client, "EGL_EXT_device_base")
                          ? eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS)
                          : nullptr;
    result.push_back({eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr), i,
                      has_extension(own, "EGL_MESA_device_software")});
  }
  return result;
}

std::vector<Candidate> candidates(int device) {
  std::vector<Candidate> devices = device_displays();
  if (device >= 0) {
    const auto chosen = std::find_if(devices.begin(), devices.end(),
                                     [&](const Candidate& c) { return c.device == device; });
    if (chosen == devices.end())
      throw Error(ExitCode::graphics, "EGL device " + std::to_string(device) +
                                          " does not exist; --list-devices prints those that do");
    return {*chosen};
  }
  std::stable_partition(devices.begin(), devices.end(),
                        [](const Candidate& c) { return !c.software; });
  if (has_extension(client_extensions(), "EGL_MESA_platform_surfaceless"))
    devices.push_back(
        {eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr), -1, true});
  devices.push_back({eglGetDisplay(EGL_DEFAULT_DISPLAY), -1, false});
  return devices;
}

void GLAPIENTRY on_message(GLenum, GLenum type, GLuint, GLenum severity, GLsizei,
                           const GLchar* text, const void* user) {
  // Notifications and performance hints are no faults of ours.
  if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || type == GL_DEBUG_TYPE_PERFORMANCE ||
      type == GL_DEBUG_TYPE_OTHER)
    return;
  static_cast<std::vector<std::string>*>(const_cast<void*>(user))->emplace_back(text);
}

/// Mesa's loader reports drivers that it does not find on stderr; they are only candidates.
void prepare_loader() {
  setenv("EGL_LOG_LEVEL", "fatal", 0);
  find_bundled_driver();
}

/// Without the notification of resets, drivers end the process or return rubbish after one.
EGLContext create_context(EGLDisplay display, EGLConfig config, bool debug, bool notify) {
  std::vector<EGLint> attributes{
      EGL_CONTEXT_MAJOR_VERSION,       4,
      EGL_CONTEXT_MINOR_VERSION,       5,
      EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
      EGL_CONTEXT_OPENGL_DEBUG,        debug ? EGL_TRUE : EGL_FALSE};
  if (notify)
    attributes.insert(attributes.end(),
                      {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  attributes.push_back(EGL_NONE);
  return eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
}

std::string text_of(GLenum name) { return reinterpret_cast<const char*>(glGetString(name)); }

}  // namespace

void find_bundled_driver() {
  namespace fs = std::filesystem;
  std::error_code none;
  for (const char* drivers : {"/etc/glvnd/egl_vendor.d", "/usr/share/glvnd/egl_vendor.d"})
    if (fs::directory_iterator(drivers, none) != fs::directory_iterator()) return;
  const fs::path mesa = library_folder() / "mesa";
  if (!fs::is_directory(mesa, none)) return;
  setenv("__EGL_VENDOR_LIBRARY_DIRS", mesa.c_str(), 0);
  setenv("LIBGL_DRIVERS_PATH", (mesa / "dri").c_str(), 0);
}

void collect_faults(std::vector<std::string>& faults) {
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(on_message, &faults);
}

std::string EglContext::offered(EGLConfig config) {
  context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, nullptr);
  if (context_ == EGL_NO_CONTEXT || !eglMakeCurrent(display_, surface_, surface_, context_))
    return "its driver has none";
  return text_of(GL_RENDERER) + " has " + text_of(GL_VERSION);
}

void EglContext::open(EGLDisplay display, bool debug) {
  display_ = display;
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) {
    display_ = EGL_NO_DISPLAY;
    throw Obstacle{0, "the EGL display cannot be initialised"};
  }
  if (!eglBindAPI(EGL_OPENGL_API)) throw Obstacle{1, "EGL offers no desktop OpenGL"};
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  const bool surfaceless = has_extension(extensions, "EGL_KHR_surfaceless_context");
  const EGLint config_attributes[] = {EGL_SURFACE_TYPE, surfaceless ? 0 : EGL_PBUFFER_BIT,
                                      EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  eglChooseConfig(display, config_attributes, &config, 1, &configs);
  if (configs == 0 && !surfaceless)
    throw Obstacle{1, "EGL offers neither surfaceless contexts nor pixel buffers"};
  if (!surfaceless) {
    const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface_ = eglCreatePbufferSurface(display, config, size);
  }
  const bool notifies = major > 1 || (major == 1 && minor >= 5);
  if (notifies) context_ = create_context(display, config, debug, true);
  if (context_ == EGL_NO_CONTEXT) context_ = create_context(display, config, debug, false);
  if (context_ == EGL_NO_CONTEXT) throw Obstacle{2, "4.5 core is needed; " + offered(config)};
  if (!eglMakeCurrent(display, surface_, surface_, context_))
    throw Obstacle{2, "the OpenGL context cannot be made current"};
  if (debug) collect_faults(faults_);
}

void EglContext::close() {
  if (display_ == EGL_NO_DISPLAY) return;
  release();
  if (surface_ != EGL_NO_SURFACE) eglDestroySurface(display_, surface_);
  if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  // The display stays initialised: other contexts of the process may share it.
  surface_ = EGL_NO_SURFACE;
  context_ = EGL_NO_CONTEXT;
  display_ = EGL_NO_DISPLAY;
}

EglContext::EglContext(const ContextOptions& options) {
  prepare_loader();
  Obstacle farthest{-1, "no EGL device"};
  for (const Candidate& candidate : candidates(options.device)) {
    try {
      open(candidate.display, options.debug);
      return;
    } catch (const Obstacle& obstacle) {
      if (obstacle.stage > farthest.stage) farthest = obstacle;
      close();
    }
  }
  throw Error(ExitCode::graphics, "no usable OpenGL: " + farthest.what + install_advice);
}

EglContext::~EglContext() { close(); }

void EglContext::make_current() const {
  // The API is a thread's: eglMakeCurrent lets go of what is current for it.
  if (!eglBindAPI(EGL_OPENGL_API) || !eglMakeCurrent(display_, surface_, surface_, context_))
    throw Error(ExitCode::graphics, "the OpenGL context was lost");
}

void EglContext::release() const {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

std::string EglContext::renderer() const { return text_of(GL_RENDERER); }
std::string EglContext::version() const { return text_of(GL_VERSION); }

void EglContext::check(const std::string& doing) const {
  std::string message = faults_.empty() ? "" : std::move(faults_.front());
  faults_.clear();
  const GLenum code = glGetError();
  if (code == GL_CONTEXT_LOST || glGetGraphicsResetStatus() != GL_NO_ERROR)
    throw Error(ExitCode::graphics,
                "OpenGL, " + doing +
                    ": the driver has reset the GPU, and what it held is lost; try again, or take "
                    "another --device");
  if (code == GL_OUT_OF_MEMORY)
    throw DeviceFull(ExitCode::memory,
                     "OpenGL, " + doing + ": the device's memory is full; " + memory_advice);
  if (message.empty() && code == GL_NO_ERROR) return;
  if (message.empty()) message = "error " + std::to_string(code);
  message.erase(std::remove(message.begin(), message.end(), '\n'), message.end());
  throw Error(ExitCode::graphics, "OpenGL, " + doing + ": " + message);
}

}  // namespace psivox::gl

namespace psivox {

std::vector<DeviceInfo> list_devices() {
  gl::prepare_loader();
  std::vector<DeviceInfo> result;
  for (const gl::Candidate& candidate : gl::device_displays()) {
    DeviceInfo info;
    info.index = candidate.device;
    info.software = candidate.software;
    try {
      const gl::EglContext context({.device = candidate.device});
      info.renderer = context.renderer();
      info.version = context.version();
    } catch (const Error& e) {
      info.problem = e.what();
    }
    result.push_back(info);
  }
  return result;
}

}  // namespace psivox
