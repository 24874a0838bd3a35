// psivox render IN.vdb -o OUT.exr: draws a picture.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "commands.h"
#include "movie.h"
#include "notices.h"
#include "picture_output.h"
#include "progress_bar.h"
#include "psivox/camera_file.h"
#include "psivox/color_scale.h"
#include "psivox/draw.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/look.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "psivox/vdb.h"
#include "render_call.h"
#include "render_frames.h"
#include "render_on_ranks.h"
#include "render_report.h"
#include "scene_options.h"
#include "thumbnail.h"

namespace psivox {
namespace {

void print_devices() {
  const std::vector<DeviceInfo> devices = list_devices();
  if (devices.empty())
    throw Error(ExitCode::graphics,
                "no EGL device; install a GPU's driver, or Mesa's software renderer (Debian: "
                "libegl1 libgl1-mesa-dri)");
  for (const DeviceInfo& device : devices) {
    std::cout << device.index << "  ";
    if (device.problem.empty())
      std::cout << device.renderer << ", " << device.version
                << (device.software ? " (software)" : "") << '\n';
    else
      std::cout << "unusable: " << device.problem << '\n';
  }
}

/// Opens the marcher while the file is read. get() throws the marcher's error.
using FutureMarcher = std::future<std::shared_ptr<Marcher>>;

Drawn draw(const RenderCall& call, Session& session, Marcher& marcher) {
  ProgressBar bar(call.quiet);
  Wish wish = wish_of(call);
  wish.progress = over_stages(bar.progress(), session.view().medium.light.has_value());
  return session.draw(marcher, wish);
}

void print_explanation(Session& session) {
  for (const Explanation& line : session.explain())
    std::printf("%-16s %s\n", line.what.c_str(), line.text.c_str());
}

/// Compares with the reference, and prints the result to standard output.
void print_check(const RenderCall& call, Session& session, RenderReport& report) {
  ProgressBar bar(call.quiet);
  report.checked = session.check_error(report.drawn.image, std::min(*call.check_error, 100000000),
                                       bar.progress());
  std::printf("error     RMS %.2e, max %.2e at %d,%d: %d pixels against the reference\n",
              report.checked->rms, report.checked->max, report.checked->max_x,
              report.checked->max_y, report.checked->pixels);
  if (const auto& plan = report.drawn.plan)
    std::printf("estimate  RMS %.2e, max %.2e: %s\n", plan->chosen.rms, plan->chosen.max,
                method_text(plan->chosen.method).c_str());
}

void render(const RenderCall& call, Session& session, FutureMarcher opened, RenderReport& report) {
  const std::shared_ptr<Marcher> marcher = opened.get();
  report.drawn = draw(call, session, *marcher);
  if (call.check_error) print_check(call, session, report);
  put_out(call, session.view(), report);
}

}  // namespace

void render_command(Arguments arguments) {
  if (const auto team = open_team(); team->size() > 1) return render_on_ranks(arguments, team);
  RenderReport report;
  report.startup_ms = process_ms();
  RenderCall call;
  if (!parse(call, arguments)) return;
  if (call.list_devices) return print_devices();
  Scene scene = call.scene.scene();
  take_layers(call, scene);
  if (call.thumbnail) make_thumbnail(call, scene);
  if (is_movie_name(call.output))
    usage("-o writes pictures; --movie " + call.output + " writes a film");
  check(call, scene);
  if (!call.quiet) print_notices(call.scene.notices());
  if (!call.time_budget) scene = with_default_tolerance(scene);
  if (scene.input.empty()) {  // only with --print-scene
    std::cout << to_json(scene);
    return;
  }

  std::optional<CameraPath> path;
  if (!call.camera_path.empty())
    path = CameraPath::read(call.camera_path, file_z_is_up(scene), call.frame_rate);
  if (const auto frames = list_frames(call, scene, path ? &*path : nullptr))
    return render_frames(call, scene, *frames, path ? &*path : nullptr);

  report.input = scene.input;
  report.output = call.output;
  FutureMarcher opened;
  if (!call.output.empty())
    opened = std::async(std::launch::async, [&scene] { return open_marcher(scene); });
  const Stopwatch reading;
  const LookedScene looked =
      with_look(scene, VdbFile(scene.input), "auto", shows_background(call), {.allowed = true});
  if (!call.quiet) print_look(looked, call.verbose);
  scene = looked.scene;
  Session session(make_view(scene, looked.fields));
  report.read_ms = reading.ms();
  if (!call.quiet) print_notices(session.view(), scene, call.verbose);
  if (call.print_scene) std::cout << to_json(session.view().scene) << std::flush;
  if (!call.camera.empty())
    write_camera(call.camera, session.view().camera,
                 z_is_up(session.view().scene, *session.view().subject));
  if (call.explain) print_explanation(session);
  if (call.output.empty()) return;

  render(call, session, std::move(opened), report);
  if (call.thumbnail) name_thumbnail(call);
  report.total_ms = process_ms();
  if (!call.stats.empty()) write_text(call.stats, report.json());
  if (call.verbose) std::fputs(report.table().c_str(), stderr);
}

}  // namespace psivox
