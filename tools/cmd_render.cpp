// psivox render IN.vdb -o OUT.exr: draws a picture.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "base/text_file.h"
#include "notices.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "psivox/picture_file.h"
#include "psivox/vdb.h"
#include "render_call.h"
#include "scene/camera_file.h"

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

// --- --thumbnail: a small picture for a file manager, which asks for one of every file that it
// shows

constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30;
constexpr std::uint64_t most_memory = std::uint64_t{1} << 30;
constexpr int most_seconds = 20;
constexpr double thumbnail_tolerance = 4e-3;  ///< a code of 8 bits

/// Completes the call: the picture is square, exact enough for 8 bits, and quiet; file, memory and
/// time are bounded. Throws Error(input) for a file beyond the bound.
void make_thumbnail(RenderCall& call, Scene& scene) {
  if (call.output.empty() || is_standard_output(call.output) || !call.movie.empty())
    usage("--thumbnail needs a file as -o, and no film");
  if (is_page_name(call.output)) usage("--thumbnail makes a picture, not a page");
  std::error_code unknown;  // reading will tell
  const std::uintmax_t bytes = std::filesystem::file_size(frame_of_file(scene.input).file, unknown);
  if (!unknown && bytes > most_bytes)
    throw Error(ExitCode::input, in_quotes(scene.input) + " has " + mebibytes(bytes) +
                                     "; --thumbnail draws files up to " + mebibytes(most_bytes));
  end_after(most_seconds, "--thumbnail: no picture after 20 s");
  call.quiet = true;
  call.thumbnail_name = call.output;
  // a name that nobody else has
  if (!has_picture_extension(call.output)) call.output += "." + std::to_string(::getpid()) + ".png";
  scene.resolution = glm::ivec2(*call.thumbnail);
  if (scene.memory_limit == 0) scene.memory_limit = most_memory;
  if (!scene.tolerance) scene.tolerance = thumbnail_tolerance;
}

/// Gives the picture the name that was asked for: some file managers name no extension.
void name_thumbnail(const RenderCall& call) {
  if (call.output == call.thumbnail_name) return;
  const std::string picture = read_text(call.output, "thumbnail");
  std::error_code unknown;
  std::filesystem::remove(call.output, unknown);
  write_text(call.thumbnail_name, picture);  // through links and to devices, with the mode as it is
}

// --- several processes that draw a picture together ----------------------------------------

[[noreturn]] void refuse(const std::string& what) {
  usage("several processes draw one picture together, " + what + "; start one process for that");
}

/// Throws Error(usage) if the call asks for what several processes cannot do.
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
    refuse("in --mode alpha, mip, lmip, minip, mean, isosurface and xray only");
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

/// Does this rank's work. The first writes and reports. Throws AgreedError in the first; the others
/// end.
void run_on(Team& team, const std::function<void()>& work) {
  if (!team.first())
    if (const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC); nothing >= 0)
      dup2(nothing, STDOUT_FILENO);
  try {
    work();
  } catch (const AgreedError& error) {
    if (!team.first()) std::exit(int(error.code()));
    throw;
  } catch (const std::exception& error) {
    // the others wait for this one
    print_notice(formatted("rank %d of %d, on %s: %s", team.rank(), team.size(),
                           team.place().machine.c_str(), error.what()));
    team.abort(int(ExitCode::failure));
  }
}

/// The process ends next, and the system takes all back: to end the GL context and to free each
/// block takes up to 11 ms.
void keep_to_the_end(std::optional<Session> session, std::shared_ptr<Marcher> marcher) {
  static auto* const kept = new auto(std::pair(std::move(session), std::move(marcher)));
  static_cast<void>(kept);
}

// --- a call, by one process or by one of several ------------------------------------------

class RenderJob {
 public:
  /// `team`: the processes that draw the picture together.
  explicit RenderJob(std::shared_ptr<Team> team) : team_(std::move(team)) {}

  void run(Arguments arguments) {
    report_.startup_ms = process_ms();
    bool goes_on = true;
    team_->agree([&] { goes_on = understand(arguments); });
    if (!goes_on) return;
    team_->check_same(to_json(scene_) + joined(call_.layers, ","), "has other options");
    if (draw_frames()) return;
    if (team_->first() && !call_.output.empty())
      remove_abandoned_files(std::filesystem::path(call_.output).parent_path());
    // opened while the file is read
    std::future<std::shared_ptr<Marcher>> opened;
    if (!call_.output.empty())
      opened = std::async(std::launch::async, [scene = scene_, place = team_->place()] {
        return open_own(scene, place);
      });
    std::optional<Session> session;
    team_->agree([&] {
      session.emplace(read(), !is_page_name(call_.output) && !call_.check_error);
      if (team_->first()) check_outputs(call_, call_.output);
      describe(*session);
    });
    if (call_.output.empty()) return;
    std::shared_ptr<Marcher> marcher;
    team_->agree([&] { marcher = opened.get(); });
    if (is_page_name(call_.output)) check_page(*session, session->view().scene, call_.page);
    draw(*session, *marcher);
    if (call_.check_error) print_check(*session);
    team_->agree([&] {
      if (team_->first()) write(*session);
    });
    keep_to_the_end(std::move(session), std::move(marcher));
  }

 private:
  bool alone() const { return team_->size() == 1; }

  /// Returns false if there is nothing left to do.
  bool understand(Arguments arguments) {
    if (!parse(call_, arguments)) return false;
    if (!team_->first()) call_.quiet = true;
    if (call_.list_devices && alone()) {
      print_devices();
      return false;
    }
    scene_ = call_.scene.scene();
    take_layers(call_, scene_);
    if (holds_codes(call_.output, call_.format) || !call_.movie.empty()) resolve_ocio(scene_);
    if (call_.thumbnail) make_thumbnail(call_, scene_);
    if (is_movie_name(call_.output))
      usage("-o writes pictures; --movie " + shell_word(call_.output) + " writes a film");
    if (team_->first()) check(call_, scene_);
    if (!alone()) check_scope(call_, scene_);
    if (!call_.quiet) print_notices(call_.scene.notices());
    scene_ = with_default_tolerance(scene_);
    report_.input = scene_.input;
    report_.output = call_.output;
    if (!scene_.input.empty()) return true;
    std::cout << to_json(scene_);  // only with --print-scene
    return false;
  }

  /// Returns false if the call asks for one picture.
  bool draw_frames() {
    if (!alone()) return false;
    std::optional<CameraPath> path;
    if (!call_.camera_path.empty())
      path = CameraPath::read(call_.camera_path, file_z_is_up(scene_), call_.frame_rate);
    const auto frames = list_frames(call_, scene_, path ? &*path : nullptr);
    if (frames) render_frames(call_, scene_, *frames, path ? &*path : nullptr);
    return frames.has_value();
  }

  View read() {
    const Stopwatch watch;
    OpenedScene opened = open_scene(
        scene_, VolumeFile(scene_.input),
        {.background = shows_background(call_), .parts = {.allowed = true, .team = team_}});
    if (!alone()) check_scope(call_, opened.looked.scene);
    report_.read_ms = watch.ms();
    if (call_.quiet) return std::move(opened.view);
    if (alone() || leaves_look_open(scene_)) print_look(opened.looked, call_.verbose);
    print_choices(opened, call_.verbose);
    return std::move(opened.view);
  }

  /// Tells what the call asks to know before the picture is drawn.
  void describe(Session& session) {
    const View& view = session.view();
    if (call_.print_scene) std::cout << to_json(view.scene) << std::flush;
    if (!call_.camera.empty() && team_->first())
      write_camera(call_.camera, view.camera, z_is_up(view.scene, *view.subject));
    if (!call_.explain) return;
    for (const Explanation& line : session.explain())
      std::cout << formatted("%-16s ", line.what.c_str()) << line.text << '\n';
  }

  void draw(Session& session, Marcher& marcher) {
    ProgressBar bar(call_.quiet);
    Wish wish = wish_of(call_);
    wish.team = team_;
    wish.progress = bar.stages();
    report_.drawn = session.draw(marcher, wish);
  }

  /// Compares with the reference, and prints the result to standard output.
  void print_check(Session& session) {
    ProgressBar bar(call_.quiet);
    report_.checked =
        session.check_error(report_.drawn, std::min(*call_.check_error, 100000000), bar.stages());
    const CheckedError& checked = *report_.checked;
    std::cout << formatted(
        "error     RMS %.2e, max %.2e at %d,%d: %d pixels against the reference\n", checked.rms,
        checked.max, checked.max_x, checked.max_y, checked.pixels);
    if (const auto& plan = report_.drawn.plan; plan && plan->rays > 0)
      std::cout << formatted("estimate  RMS %.2e, max %.2e: %s\n", plan->chosen.rms,
                             plan->chosen.max, method_text(plan->chosen.method).c_str());
    const std::optional<double>& tolerance = report_.drawn.view.scene.tolerance;
    if (tolerance && checked.rms > *tolerance && !call_.quiet)
      print_notice("the error is above the tolerance of " + number_text(*tolerance));
  }

  void write(Session& session) {
    put_out(call_, session, report_);
    if (call_.thumbnail) name_thumbnail(call_);
    report_.total_ms = process_ms();
    if (!call_.stats.empty()) write_text(call_.stats, report_.json());
    if (call_.verbose) print(stderr, report_.table());
  }

  std::shared_ptr<Team> team_;
  RenderCall call_;
  Scene scene_;
  RenderReport report_;
};

}  // namespace

void render_command(Arguments arguments) {
  const std::shared_ptr<Team> team = open_team();
  const auto work = [&] { RenderJob(team).run(arguments); };
  if (team->size() > 1)
    run_on(*team, work);
  else
    work();
}

}  // namespace psivox
