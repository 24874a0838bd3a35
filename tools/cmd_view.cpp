// psivox view IN.vdb: the preview window.

#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/statistics.h"
#include "base/text.h"
#include "command_line.h"
#include "notices.h"
#include "psivox/picture_file.h"
#include "view/picture_maker.h"
#ifdef PSIVOX_VIEWER
#include "view/benchmark.h"
#endif

namespace psivox {
namespace {

struct ViewCall {
  SceneOptions scene;
  view::ViewerOptions window;
  int orbit = 0, session = 0;
  std::string context = "native";
};

bool parse(ViewCall& call, Arguments arguments) {
  CommandLine line("view", "Shows a volume (.vdb, NIfTI, NRRD) in a window.", {"watch"},
                   {"smoke.vdb", "'fire.####.vdb'", "smoke.vdb --watch --light camera:1,-1,-1"});
  line.add_value("--frame-budget", call.window.frame_budget_ms, "MS",
                 "time for one picture while the camera moves [ms]")
      ->check(number_in<double>({.min = 0}))
      ->capture_default_str();
  line.add_flag("--watch", call.window.watch, "read the file again when it changes");
  line.add_value("--context", call.context, "native|egl",
                 "create the window's OpenGL context by the window system or by EGL")
      ->check(one_of<std::string>({"native", "egl"}))
      ->capture_default_str();
  line.add_flag("--gl-debug", call.window.debug, "treat messages of the OpenGL driver as errors");
  line.add_flag("-q,--quiet", call.window.quiet, "print errors only");
  line.add_value("IN.vdb", call.window.inputs, "",
                 "volume to show; a sequence: fire.####.vdb, a folder, or several files")
      ->take_all();
  call.scene.add_to(line, {"input"});
  // for measurements and tests of the window; see docs/preview.md
  line.begin_group(hidden_group);
  const CLI::Validator count = number_in<int>({.min = 2});
  line.add_option("--benchmark-orbit", call.orbit,
                  "orbit until N pictures were shown, print the times, and end")
      ->check(count);
  line.add_option("--benchmark-session", call.session,
                  "open the files of the input's folder in turn, N times, and orbit around each; "
                  "print memory and OpenGL objects, and end")
      ->check(count);
  if (!line.read(arguments)) return false;
  const std::vector<std::string>& inputs = call.window.inputs;
  if (!inputs.empty()) call.scene.set("input", inputs.front());
  call.window.egl = call.context == "egl";
  call.window.count_objects = call.session > 0;
  return true;
}

#ifdef PSIVOX_VIEWER
void print_orbit(view::Viewer& viewer, int pictures) {
  const view::OrbitTimes times = view::benchmark_orbit(viewer, pictures);
  const glm::ivec2 size = viewer.window().size();
  const auto within = [&](double part) { return percentile(times.intervals_ms, part); };
  std::cout << formatted(
      "orbit     %d pictures in a window of %dx%d\n"
      "interval  50 %% within %.1f ms, 90 %% within %.1f ms, 99 %% within %.1f ms, longest %.1f "
      "ms\n"
      "opened    exact picture begun after %.2f s, complete after %.2f s\n"
      "refined   %.2f s after the last movement\n"
      "renderer  %s\n",
      pictures, size.x, size.y, within(0.5), within(0.9), within(0.99), within(1),
      1e-3 * times.first_part_ms, 1e-3 * times.first_exact_ms, 1e-3 * times.refine_ms,
      viewer.pictures().renderer.c_str());
}

void print_objects(const char* when, const char* context, const gl::ObjectCounts& n) {
  std::cout << formatted(
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
  std::cout << formatted("session   %d switches among %d files in %.0f s; %d errors\n",
                         report.switches, int(files.size()), report.seconds,
                         viewer.messages().error_count());
  std::cout << formatted("memory    %.1f MiB when settled, %.1f at the end, %.1f at most\n",
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
  Scene scene = call.scene.scene();
  std::vector<std::string> notices = call.scene.notices();
  if (!scene.holdout.empty()) {
    notices.push_back("--holdout is left out: its depths are of one camera, and a window's moves");
    scene.holdout.clear();
    scene.holdout_depth = DepthKind::z;
  }
  resolve_ocio(scene);
  if (scene.background && scene.background->environment) {
    notices.push_back("--background environment is left out: the window shows a colour there");
    scene.background.reset();
  }
  if (!call.window.quiet) print_notices(notices);
  if ((call.orbit || call.session) && scene.input.empty())
    usage("no input to orbit around; give IN.vdb");
#ifdef PSIVOX_VIEWER
  call.window.tell_look = [](const LookedScene& looked) {
    print_look(looked, false, "Ctrl+C in the window copies its options");
  };
  call.window.render = [](const std::vector<std::string>& saved) {
    const InputProtection kept;
    render_command(saved);
  };
  view::Viewer viewer(scene, call.window);
  if (call.orbit) print_orbit(viewer, call.orbit);
  if (call.session) print_session(viewer, scene.input, call.session);
  if (!call.orbit && !call.session) viewer.run();
#else
  throw Error(ExitCode::graphics,
              "this psivox was built without its window (PSIVOX_BUILD_VIEWER); psivox render draws "
              "the same picture to a file");
#endif
}

}  // namespace psivox
