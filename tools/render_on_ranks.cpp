#include "render_on_ranks.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <future>
#include <iostream>
#include <optional>
#include <utility>

#include "frame_list.h"
#include "notices.h"
#include "picture_output.h"
#include "progress_bar.h"
#include "psivox/camera_file.h"
#include "psivox/look.h"
#include "psivox/parts.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "render_call.h"
#include "render_report.h"

namespace psivox {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  usage("several processes draw one picture together, " + what + "; start one process for that");
}

/// Throws if the call asks for what several processes cannot do.
void check_scope(const RenderCall& call, const Scene& scene) {
  if (call.list_devices) refuse("and do not list devices");
  if (call.explain) refuse("without --explain");
  if (call.check_error) refuse("without --check-error");
  if (!call.camera_path.empty() || call.turntable || !call.movie.empty() ||
      list_frames(call, scene, nullptr))
    refuse("not a sequence");
  if (scene.renderer == RendererKind::reference) refuse("not by --renderer reference");
  if (call.output.empty()) refuse("and need -o");
  if (scene.shows(Shows::plane) || !info(scene.mode).in_parts)
    refuse("in --mode alpha, mip, lmip, isosurface and xray only");
  if (const std::string obstacle = parts_obstacle(scene); !obstacle.empty())
    refuse("in " + obstacle + " only");
}

/// The marcher of this rank: the ranks of a machine take its GPUs in turn.
std::shared_ptr<Marcher> open_own(Scene scene, const Team::Place& place) {
  if (scene.renderer == RendererKind::gl && scene.device < 0 && place.local_size > 1) {
    std::vector<int> gpus;
    for (const DeviceInfo& device : list_devices())
      if (device.problem.empty() && !device.software) gpus.push_back(device.index);
    if (gpus.size() > 1) scene.device = gpus[place.in_turn(gpus.size())];
  }
  return open_marcher(scene);
}

struct Together {
  std::shared_ptr<Team> team;
  RenderCall call;
  Scene scene;
  RenderReport report;

  /// Returns false if there is nothing to draw.
  bool understand(Arguments arguments);
  std::optional<Session> read();
  void draw(Session& session, std::future<std::shared_ptr<Marcher>> opened);
  void write(Session& session);
};

bool Together::understand(Arguments arguments) {
  bool draws = true;
  team->agree([&] {
    draws = parse(call, arguments);
    if (!draws) return;
    scene = call.scene.scene();
    take_layers(call, scene);
    if (team->first()) check(call, scene);
    check_scope(call, scene);
    if (!call.time_budget) scene = with_default_tolerance(scene);
  });
  if (!draws) return false;
  if (!team->first()) call.quiet = true;
  team->check_same(to_json(scene) + joined(call.layers, ","), "has other options");
  report.input = scene.input;
  report.output = call.output;
  return true;
}

std::optional<Session> Together::read() {
  std::optional<Session> session;
  team->agree([&] {
    const Stopwatch watch;
    const LookedScene looked =
        with_look(scene, VdbFile(scene.input), "auto", shows_background(call), {true, team});
    if (leaves_look_open(scene) && !call.quiet) print_look(looked, call.verbose);
    scene = looked.scene;
    check_scope(call, scene);
    session.emplace(make_view(scene, looked.fields));
    report.read_ms = watch.ms();
  });
  return session;
}

void Together::draw(Session& session, std::future<std::shared_ptr<Marcher>> opened) {
  std::shared_ptr<Marcher> marcher;
  team->agree([&] { marcher = opened.get(); });
  ProgressBar bar(call.quiet);
  Wish wish = wish_of(call);
  wish.team = team;
  wish.progress = over_stages(bar.progress(), session.view().medium.light.has_value());
  report.drawn = session.draw(*marcher, wish);
}

void Together::write(Session& session) {
  team->agree([&] {
    if (!team->first()) return;
    const View& view = session.view();
    if (!call.camera.empty())
      write_camera(call.camera, view.camera, z_is_up(view.scene, *view.subject));
    put_out(call, view, report);
    report.total_ms = process_ms();
    if (!call.stats.empty()) write_text(call.stats, report.json());
    if (call.verbose) std::fputs(report.table().c_str(), stderr);
  });
}

}  // namespace

void render_on_ranks(Arguments arguments, const std::shared_ptr<Team>& team) {
  if (!team->first())
    if (const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC); nothing >= 0)
      dup2(nothing, STDOUT_FILENO);
  try {
    Together work{team, {}, {}, {}};
    work.report.startup_ms = process_ms();
    if (!work.understand(arguments)) return;
    auto opened = std::async(std::launch::async, [scene = work.scene, place = team->place()] {
      return open_own(scene, place);
    });
    std::optional<Session> session = work.read();
    if (!work.call.quiet) print_notices(work.call.scene.notices());
    if (!work.call.quiet) print_notices(session->view(), work.scene, work.call.verbose);
    if (work.call.print_scene) std::cout << to_json(session->view().scene) << std::flush;
    work.draw(*session, std::move(opened));
    work.write(*session);
  } catch (const AgreedError& error) {
    if (!team->first()) std::exit(static_cast<int>(error.code()));
    throw;
  } catch (const std::exception& error) {
    // the others wait for this one
    std::fprintf(stderr, "psivox: rank %d of %d, on %s: %s\n", team->rank(), team->size(),
                 team->place().machine.c_str(), error.what());
    team->abort(static_cast<int>(ExitCode::failure));
  }
}

}  // namespace psivox
