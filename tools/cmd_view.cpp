// psivox view IN.vdb: the preview window.

#include <charconv>
#include <cstdio>
#include <string>
#include <vector>

#include "command_line.h"
#include "commands.h"
#include "psivox/error.h"
#include "scene_options.h"
#ifdef PSIVOX_VIEWER
#include "view/benchmark.h"
#include "view/viewer.h"
#endif

namespace psivox {
namespace {

struct ViewCall {
  SceneOptions scene;
  std::string frame_budget = "33", orbit, context = "native";
  bool watch = false, gl_debug = false, quiet = false;
};

bool parse(ViewCall& call, Arguments arguments) {
  CommandLine line("view", "Shows a .vdb in a window.");
  line.add_value("--frame-budget", 0, "MS",
                 "time that a picture may take while something moves [ms] (default: 33)",
                 call.frame_budget);
  line.add_flag("--watch", 0, "read the file again when it changes", call.watch);
  line.add_value("--benchmark-orbit", 0, "N",
                 "orbit until N pictures were shown, print the times, and end", call.orbit);
  line.add_value("--context", 0, "native|egl",
                 "the window's OpenGL context by the window system's own interface, or by EGL "
                 "(default: native)",
                 call.context);
  line.add_flag("--gl-debug", 0, "messages of the OpenGL driver are errors", call.gl_debug);
  line.add_flag("--quiet", 'q', "print errors only", call.quiet);
  call.scene.add_to(line);
  return line.parse(arguments);
}

int read_orbit(const std::string& text) {
  int count = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, count);
  if (error != std::errc() || stop != end || count < 2)
    usage("--benchmark-orbit " + in_quotes(text) + ": expected a whole number, at least 2");
  return count;
}

}  // namespace

void view_command(Arguments arguments) {
  ViewCall call;
  if (!parse(call, arguments)) return;
  const Scene scene = call.scene.scene();
  const double budget_ms = read_limit("--frame-budget", call.frame_budget);
  const int orbit = call.orbit.empty() ? 0 : read_orbit(call.orbit);
  if (call.context != "native" && call.context != "egl")
    usage("--context " + in_quotes(call.context) + ": expected native or egl");
  if (orbit && scene.input.empty()) usage("no input to orbit around; give IN.vdb");
#ifdef PSIVOX_VIEWER
  view::ViewerOptions options;
  options.frame_budget_ms = budget_ms;
  options.watch = call.watch;
  options.egl = call.context == "egl";
  options.debug = call.gl_debug;
  options.quiet = call.quiet;
  options.render = [](const std::vector<std::string>& saved) { render_command(saved); };
  view::Viewer viewer(scene, options);
  if (!orbit) return viewer.run();
  const view::OrbitTimes times = view::benchmark_orbit(viewer, orbit);
  const glm::ivec2 size = viewer.window().size();
  std::printf(
      "orbit     %d pictures in a window of %dx%d: median %.1f ms, 90 %% within %.1f ms\n"
      "refined   %.2f s after the last movement; first exact picture after %.2f s\n"
      "renderer  %s\n",
      orbit, size.x, size.y, times.median_ms, times.p90_ms, 1e-3 * times.refine_ms,
      1e-3 * times.first_exact_ms, viewer.renderer().c_str());
#else
  (void)budget_ms;
  throw Error(ExitCode::graphics,
              "this psivox was built without its window (PSIVOX_BUILD_VIEWER); psivox render draws "
              "the same picture to a file");
#endif
}

}  // namespace psivox
