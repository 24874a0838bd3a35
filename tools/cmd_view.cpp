// psivox view IN.vdb: the preview window.

#include <iostream>
#include <string>
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
  int orbit = 0;
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
  line.add_option("--benchmark-orbit", call.orbit,
                  "orbit until N pictures were shown, print the times, and end")
      ->check(number_in<int>({.min = 2}));
  if (!line.read(arguments)) return false;
  const std::vector<std::string>& inputs = call.window.inputs;
  if (!inputs.empty()) call.scene.set("input", inputs.front());
  call.window.egl = call.context == "egl";
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
  if (call.orbit && scene.input.empty()) usage("no input to orbit around; give IN.vdb");
#ifdef PSIVOX_VIEWER
  call.window.tell_look = [](const LookedScene& looked) {
    print_look(looked, false, "Ctrl+C in the window copies its options");
  };
  call.window.render = [](const std::vector<std::string>& saved) {
    const InputProtection kept;
    render_command(saved);
  };
  view::Viewer viewer(scene, call.window);
  if (call.orbit)
    print_orbit(viewer, call.orbit);
  else
    viewer.run();
#else
  throw Error(ExitCode::graphics,
              "this psivox was built without its window (PSIVOX_BUILD_VIEWER); psivox render draws "
              "the same picture to a file");
#endif
}

}  // namespace psivox
