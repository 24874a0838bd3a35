#include "render_on_ranks.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "frame_list.h"
#include "psivox/medium.h"

namespace psivox {
namespace {

[[noreturn]] void refuse(const std::string& what) {
  usage("several processes draw one picture together, " + what + "; start one process for that");
}

}  // namespace

void check_scope(const RenderCall& call, const Scene& scene) {
  if (call.list_devices) refuse("and do not list devices");
  if (call.explain) refuse("without --explain");
  if (call.check_error) refuse("without --check-error");
  if (std::ranges::count(call.layers, "deep")) refuse("without --aov deep");
  if (!call.camera_path.empty() || call.turntable || !call.movie.empty() ||
      list_frames(call, scene, nullptr))
    refuse("not a sequence");
  if (scene.renderer == RendererKind::reference) refuse("not by --renderer reference");
  if (call.output.empty()) refuse("and need -o");
  if (is_page_name(call.output)) refuse("not a page");
  if (scene.shows(Shows::plane) || !info(scene.mode).in_parts)
    refuse("in --mode alpha, mip, lmip, isosurface and xray only");
  if (const std::string obstacle = parts_obstacle(scene); !obstacle.empty())
    refuse("in " + obstacle + " only");
}

std::shared_ptr<Marcher> open_own(Scene scene, const Team::Place& place) {
  if (scene.renderer == RendererKind::gl && scene.device < 0 && place.local_size > 1) {
    std::vector<int> gpus;
    for (const DeviceInfo& device : list_devices())
      if (device.problem.empty() && !device.software) gpus.push_back(device.index);
    if (gpus.size() > 1) scene.device = gpus[place.in_turn(gpus.size())];
  }
  return open_marcher(scene);
}

void run_on(Team& team, const std::function<void()>& work) {
  if (!team.first())
    if (const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC); nothing >= 0)
      dup2(nothing, STDOUT_FILENO);
  try {
    work();
  } catch (const AgreedError& error) {
    if (!team.first()) std::exit(static_cast<int>(error.code()));
    throw;
  } catch (const std::exception& error) {
    // the others wait for this one
    std::fprintf(stderr, "psivox: rank %d of %d, on %s: %s\n", team.rank(), team.size(),
                 team.place().machine.c_str(), error.what());
    team.abort(static_cast<int>(ExitCode::failure));
  }
}

}  // namespace psivox
