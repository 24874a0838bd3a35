// psivox view IN.vdb: the preview window.

#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "command_line.h"
#include "commands.h"
#include "psivox/error.h"
#include "psivox/text.h"
#include "scene_options.h"
#ifdef PSIVOX_VIEWER
#include "view/benchmark.h"
#include "view/viewer.h"
#endif

namespace psivox {
namespace {

struct ViewCall {
  SceneOptions scene;
  std::string frame_budget = "33", orbit, session, context = "native";
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
  line.add_value(
      "--benchmark-session", 0, "N",
      "open the files of the input's folder one after another, N times, and orbit around "
      "each; print memory and OpenGL objects, and end",
      call.session);
  line.add_value("--context", 0, "native|egl",
                 "the window's OpenGL context by the window system's own interface, or by EGL "
                 "(default: native)",
                 call.context);
  line.add_flag("--gl-debug", 0, "messages of the OpenGL driver are errors", call.gl_debug);
  line.add_flag("--quiet", 'q', "print errors only", call.quiet);
  call.scene.add_to(line);
  return line.parse(arguments);
}

int read_count(const char* option, const std::string& text) {
  int count = 0;
  if (!read_number(text, count) || count < 2)
    usage(std::string(option) + " " + in_quotes(text) + ": expected a whole number, at least 2");
  return count;
}

#ifdef PSIVOX_VIEWER
void print_orbit(view::Viewer& viewer, int pictures) {
  const view::OrbitTimes times = view::benchmark_orbit(viewer, pictures);
  const glm::ivec2 size = viewer.window().size();
  std::printf(
      "orbit     %d pictures in a window of %dx%d: median %.1f ms, 90 %% within %.1f ms\n"
      "refined   %.2f s after the last movement; first exact picture after %.2f s\n"
      "renderer  %s\n",
      pictures, size.x, size.y, times.median_ms, times.p90_ms, 1e-3 * times.refine_ms,
      1e-3 * times.first_exact_ms, viewer.renderer().c_str());
}

void print_objects(const char* when, const char* context, const gl::ObjectCounts& n) {
  std::printf(
      "%-9s %s: %d textures, %d buffers, %d framebuffers, %d programs, %d shaders, %d vertex "
      "arrays, %d queries\n",
      when, context, n.textures, n.buffers, n.framebuffers, n.programs, n.shaders, n.vertex_arrays,
      n.queries);
}

void print_session(view::Viewer& viewer, const std::string& input, int switches) {
  std::vector<std::string> files{input};
  const std::filesystem::path first(input);
  const std::filesystem::path folder = first.has_parent_path() ? first.parent_path() : ".";
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".vdb" && entry.path().filename() != first.filename())
      files.push_back(entry.path().string());
  const view::SessionReport report = view::benchmark_session(viewer, files, switches);
  std::printf("session   %d switches among %d files in %.0f s; %d errors\n", report.switches,
              static_cast<int>(files.size()), report.seconds, viewer.problems());
  std::printf("memory    %.1f MiB when settled, %.1f at the end, %.1f at most\n",
              report.settled.resident_mib, report.end.resident_mib, report.most_mib);
  for (const auto& [when, state] :
       {std::pair("settled", report.settled), std::pair("end", report.end)}) {
    print_objects(when, "window", state.window);
    print_objects(when, "pictures", state.pictures);
  }
}
#endif

}  // namespace

void view_command(Arguments arguments) {
  ViewCall call;
  if (!parse(call, arguments)) return;
  const Scene scene = call.scene.scene();
  const double budget_ms = read_limit("--frame-budget", call.frame_budget);
  const int orbit = call.orbit.empty() ? 0 : read_count("--benchmark-orbit", call.orbit);
  const int session = call.session.empty() ? 0 : read_count("--benchmark-session", call.session);
  if (call.context != "native" && call.context != "egl")
    usage("--context " + in_quotes(call.context) + ": expected native or egl");
  if ((orbit || session) && scene.input.empty()) usage("no input to orbit around; give IN.vdb");
#ifdef PSIVOX_VIEWER
  view::ViewerOptions options;
  options.frame_budget_ms = budget_ms;
  options.watch = call.watch;
  options.egl = call.context == "egl";
  options.debug = call.gl_debug;
  options.quiet = call.quiet;
  options.count_objects = session > 0;
  options.render = [](const std::vector<std::string>& saved) { render_command(saved); };
  view::Viewer viewer(scene, options);
  if (orbit) print_orbit(viewer, orbit);
  if (session) print_session(viewer, scene.input, session);
  if (!orbit && !session) viewer.run();
#else
  (void)budget_ms;
  throw Error(ExitCode::graphics,
              "this psivox was built without its window (PSIVOX_BUILD_VIEWER); psivox render draws "
              "the same picture to a file");
#endif
}

}  // namespace psivox
