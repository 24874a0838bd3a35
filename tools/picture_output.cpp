
#include <fcntl.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "app/command_text.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "notices.h"
#include "psivox/picture_file.h"
#include "psivox/sequence.h"
#include "psivox/vdb.h"
#include "render_call.h"

namespace psivox {

bool shows_background(const RenderCall& call) {
  return call.output.empty() ? !call.movie.empty() : shows_background(call.output, call.format);
}

void write_picture(const RenderCall& call, RenderReport& report) {
  Drawn& drawn = report.drawn;
  report.written = write_picture(drawn.image, drawn.view.scene, legend_of(drawn.view),
                                 drawn.stats.renderer, {report.output, call.format, call.layers});
}

void put_out(const RenderCall& call, Session& session, RenderReport& report) {
  const auto say = [&](const std::vector<std::string>& notices) {
    if (!call.quiet) print_notices(notices);
  };
  const Image& image = report.drawn.image;
  say(report.drawn.notices);
  if (const auto blank = blank_reason(report.drawn.view, image); !blank.empty()) say({blank});
  if (is_page_name(call.output)) {
    const Stopwatch writing;
    const std::string page = page_text(session, report.drawn, call.page);
    write_text(call.output, page);
    report.written.bytes = page.size();
    report.written.write_ms = writing.ms();
    return say({formatted("the page is %.2f MB", double(page.size()) / 1e6)});
  }
  constexpr double long_write = 1e7;  // [pixels]; a second and more
  if (double(image.width) * image.height > long_write) say({"writing " + in_quotes(call.output)});
  write_picture(call, report);
  say(report.written.notices);
}

namespace {

double per_ray(std::uint64_t count, const RenderStats& stats) {
  return stats.rays ? double(count) / double(stats.rays) : 0;
}

using Json = nlohmann::ordered_json;

/// The error that was asked for, estimated and measured, and how its method was chosen.
Json error_json(const RenderReport& report) {
  const std::optional<MarchPlan>& plan = report.drawn.plan;
  Json error = Json::object();
  if (report.drawn.view.scene.tolerance) error["tolerance"] = *report.drawn.view.scene.tolerance;
  if (plan) {
    error["method"] = method_text(plan->chosen.method);
    error["reached"] = plan->reached;
    error["estimated_rms"] = plan->chosen.rms;
    error["estimated_max"] = plan->chosen.max;
    error["pilot_rays"] = plan->rays;
    error["pilot_samples"] = plan->samples;
    for (const Trial& trial : plan->trials)
      error["trials"].push_back({{"method", method_text(trial.method)},
                                 {"rays", trial.rays},
                                 {"rms", trial.rms},
                                 {"max", trial.max},
                                 {"samples_per_ray", trial.samples},
                                 {"cost", trial.cost}});
  }
  if (report.drawn.light) {
    error["light_method"] = report.drawn.light->method;
    error["light_rms"] = report.drawn.light->rms;
    error["light_max"] = report.drawn.light->max;
  }
  if (report.drawn.difference) {
    error["layer_rms"] = report.drawn.difference->rms;
    error["layer_max"] = report.drawn.difference->max;
  }
  if (report.drawn.bound) error["bound_max"] = *report.drawn.bound;
  if (report.checked) {
    error["checked_pixels"] = report.checked->pixels;
    error["checked_rms"] = report.checked->rms;
    error["checked_max"] = report.checked->max;
    error["checked_light_ms"] = report.checked->light_ms;
    error["checked_reference_ms"] = report.checked->reference_ms;
  }
  return error;
}

/// ffmpeg's name of the format; null: it is no film's.
const char* format_of(const std::string& path) {
  constexpr std::pair<const char*, const char*> formats[] = {
      {".mp4", "mp4"}, {".mov", "mov"}, {".mkv", "matroska"}, {".avi", "avi"}};
  for (const auto& [extension, format] : formats)
    if (path.ends_with(extension)) return format;
  return nullptr;
}

/// What every player shows: H.264, colours at half resolution and by BT.709, as the file says, an
/// even width and height: of an odd one the last column or row is left out.
const std::string encoding =
    "-vf 'crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=out_color_matrix=bt709:out_range=tv' "
    "-c:v libx264 -crf 17 -pix_fmt yuv420p -colorspace bt709 -color_primaries bt709 "
    "-color_trc bt709 -color_range tv";

}  // namespace

double process_ms() {
  // Field 22 of /proc/self/stat: the start in clock ticks since boot. Field 2 is the program's name
  // in parentheses, which may hold anything.
  std::ifstream file("/proc/self/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(text.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) fields >> skipped;
  double ticks = 0;
  timespec now{};
  if (!(fields >> ticks) || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return 0;
  const double now_s = double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
  return 1e3 * (now_s - ticks / double(sysconf(_SC_CLK_TCK)));
}

nlohmann::ordered_json RenderReport::as_json() const {
  const RenderStats& stats = drawn.stats;
  const PreparationTimes& times = drawn.times;
  const AtlasSize& atlas = drawn.atlas;
  Json counts = {{"rays", stats.rays},
                 {"samples", stats.samples},
                 {"steps", stats.steps},
                 {"cells", stats.cells},
                 {"samples_per_ray", per_ray(stats.samples, stats)},
                 {"passes", stats.passes},
                 {"clipped_pixels", written.clipped}};
  if (!drawn.image.deep.counts.empty()) counts["deep_samples"] = drawn.image.deep.samples.size();
  const Json error = error_json(*this);
  return {{"version", PSIVOX_VERSION},
          {"renderer", stats.renderer},
          {"guard", reading_guard()},
          {"input", input},
          {"output", output},
          {"times_ms",
           {{"startup", startup_ms},
            {"read", read_ms},
            {"atlas", times.atlas_ms},
            {"light", times.light_ms},
            {"light_cpu", times.light_cpu_ms},
            {"plan", times.plan_ms},
            {"plan_cpu", times.plan_cpu_ms},
            {"gl_init", stats.gl_init_ms},
            {"shader", stats.shader_ms},
            {"upload", stats.upload_ms},
            {"march", stats.march_ms},
            {"march_cpu", stats.cpu_ms},
            {"march_gpu", stats.gpu_ms},
            {"write", written.write_ms},
            {"total", total_ms}}},
          {"counts", counts},
          {"error", error},
          {"bytes",
           {{"atlas", atlas.bytes()},
            {"atlas_texels", atlas.texel_bytes},
            {"atlas_pages", atlas.page_bytes},
            {"atlas_constants", atlas.constant_bytes},
            {"output", written.bytes}}},
          {"bricks", {{"textured", atlas.textured_bricks}, {"constant", atlas.constant_bricks}}}};
}

std::string RenderReport::json() const {
  return as_json().dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string RenderReport::table() const {
  const RenderStats& stats = drawn.stats;
  const PreparationTimes& times = drawn.times;
  const AtlasSize& atlas = drawn.atlas;
  std::string out = "renderer  " + stats.renderer + "\nguard     " + reading_guard() + "\n";
  out += formatted("times     startup %.1f, read %.1f, atlas %.1f, GL init %.1f, shader %.1f, ",
                   startup_ms, read_ms, times.atlas_ms, stats.gl_init_ms, stats.shader_ms);
  if (times.light_ms > 0) out += formatted("light %.1f, ", times.light_ms);
  if (times.plan_ms > 0) out += formatted("plan %.1f, ", times.plan_ms);
  out += formatted("upload %.1f, march %.1f, ", stats.upload_ms, stats.march_ms);
  if (checked)
    out += formatted("light to check %.1f, check %.1f, ", checked->light_ms, checked->reference_ms);
  out += formatted("write %.1f; total %.1f ms\n", written.write_ms, total_ms);
  if (const auto& plan = drawn.plan) {
    out += "march     " + method_text(plan->chosen.method);
    if (plan->rays > 0)
      out += formatted("; estimated error RMS %.1e, max %.1e (%d rays)", plan->chosen.rms,
                       plan->chosen.max, plan->rays);
    out += "\n";
  }
  if (const auto& light = drawn.light)
    out += formatted("light     %s, %d direction%s; estimated error RMS %.1e, max %.1e\n",
                     light->method.c_str(), light->beams, light->beams == 1 ? "" : "s", light->rms,
                     light->max);
  if (const auto& difference = drawn.difference)
    out +=
        formatted("error     RMS %.1e, max %.1e: layer error\n", difference->rms, difference->max);
  if (drawn.bound) out += formatted("error     at most %.1e: layer bound\n", *drawn.bound);
  out += formatted("rays      %llu", static_cast<unsigned long long>(stats.rays));
  if (const std::size_t pixels = drawn.image.deep.counts.size())
    out += formatted(", %.1f deep samples a pixel\n",
                     double(drawn.image.deep.samples.size()) / double(pixels));
  else if (stats.cells)
    out += formatted(", %.1f cells each\n", per_ray(stats.cells, stats));
  else
    out += formatted(", %.1f samples and %.1f steps each\n", per_ray(stats.samples, stats),
                     per_ray(stats.steps, stats));
  out += formatted("atlas     %.2f MiB: %llu textured and %llu constant bricks\n",
                   double(atlas.bytes()) / (1 << 20),
                   static_cast<unsigned long long>(atlas.textured_bricks),
                   static_cast<unsigned long long>(atlas.constant_bricks));
  out += formatted("output    %.2f MiB\n", double(written.bytes) / (1 << 20));
  return out;
}

bool is_movie_name(const std::string& path) { return format_of(path); }

bool can_make_movies() {
  const char* folders = std::getenv("PATH");
  for (const std::string& folder : split(folders ? folders : "", ':'))
    if (::access((std::filesystem::path(folder) / "ffmpeg").c_str(), X_OK) == 0) return true;
  return false;
}

Movie::Movie(const std::string& path, double frame_rate) : path_(path), frame_rate_(frame_rate) {
  try {
    file_.emplace(path);
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

Movie::~Movie() {
  if (ffmpeg_) ::pclose(ffmpeg_);
}

void Movie::fail(const std::string& why) {
  throw Error(ExitCode::output, "cannot write " + in_quotes(path_) + ": " + why);
}

void Movie::start(int width, int height) {
  // By its descriptor: ffmpeg would take a part of a name for a protocol, and would make the file
  // again if it were removed meanwhile.
  const int file = file_->open();
  ::fcntl(file, F_SETFD, 0);  // ffmpeg inherits it
  const std::string command =
      "exec ffmpeg -loglevel error -xerror -y -f rawvideo -pixel_format rgb24 -video_size " +
      std::to_string(width) + "x" + std::to_string(height) + " -framerate " +
      number_text(frame_rate_) + " -i - " + encoding + " -f " + format_of(path_) +
      " file:/dev/fd/" + std::to_string(file);
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early makes a write fail instead
  std::signal(SIGCHLD, SIG_DFL);  // if a parent ignored it, pclose() would not find ffmpeg's code
  ffmpeg_ = ::popen(command.c_str(), "we");
  ::close(file);
  if (!ffmpeg_) fail(std::string("ffmpeg: ") + std::strerror(errno));
}

void Movie::add(const Image& image, const Display& display) {
  if (!ffmpeg_) start(image.width, image.height);
  const std::vector<std::uint8_t> bytes = srgb_bytes(image, display);
  if (std::fwrite(bytes.data(), 1, bytes.size(), ffmpeg_) != bytes.size() ||
      std::fflush(ffmpeg_) != 0)
    fail("ffmpeg ended early");
}

void Movie::finish() {
  if (!ffmpeg_) return;
  if (::pclose(std::exchange(ffmpeg_, nullptr)) != 0) fail("ffmpeg failed");
  try {
    file_->show();
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

}  // namespace psivox
