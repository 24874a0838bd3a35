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
#include "notices.h"
#include "picture_memory.h"
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
#include "render_report.h"
#include "scene_file.h"
#include "scene_options.h"

namespace psivox {
namespace {

/// --aov's names.
constexpr std::pair<const char*, bool Layers::*> layer_names[] = {
    {"depth", &Layers::depth},
    {"transmittance", &Layers::transmittance},
    {"steps", &Layers::steps},
    {"samples", &Layers::samples},
    {"error", &Layers::error}};

std::vector<std::string> known_layers() {
  std::vector<std::string> names;
  for (const auto& [name, member] : layer_names) names.emplace_back(name);
  return names;
}

struct RenderCall {
  SceneOptions scene;
  std::string output, stats, camera;
  std::vector<std::string> layers;    ///< named by --aov
  std::optional<int> check_error;     ///< pixels
  std::optional<double> time_budget;  ///< [ms]
  WriteOptions format;
  bool print_scene = false, explain = false, verbose = false, quiet = false, list_devices = false;
};

bool wants(const RenderCall& call, const char* layer) {
  return std::find(call.layers.begin(), call.layers.end(), layer) != call.layers.end();
}

void add_outputs(CommandLine& line, RenderCall& call) {
  const std::string output = group_name(ParameterGroup::output);
  line.add_option("-o,--output", call.output,
                  "picture to write: .exr or .tif (linear, premultiplied), .png (sRGB); without "
                  "alpha: .jpg or .webp (sRGB), .hdr (linear)")
      ->type_name("FILE")
      ->group(output);
  std::vector<std::string> layers = known_layers();
  layers.emplace_back("none");
  line.add_list("--aov", call.layers,
                "extra layers of the .exr: " + joined(known_layers(), ", ") +
                    "; none drops those of --scene's picture")
      ->check(CLI::IsMember(layers).description(""))
      ->group(output);
  line.add_flag("--half", call.format.half, "store the .exr in 16-bit floats")->group(output);
  line.add_option(
          "--bits", call.format.bits,
          "bits per channel of a .png (default: 8) or of a .tif, which then is sRGB instead "
          "of linear 32-bit floats")
      ->type_name("8|16")
      ->check(CLI::IsMember({8, 16}).description(""))
      ->group(output);
  line.add_flag("--print-scene", call.print_scene,
                "print the complete scene as JSON; render only if -o is given")
      ->group(output);
  line.add_option(
          "--export-camera", call.camera,
          "write the camera as .gltf (Blender reads it) or ParaView's .pvcc; render only if "
          "-o is given")
      ->type_name("FILE")
      ->group(output);
  line.add_flag("--explain", call.explain,
                "print what the march computes and skips, and why; render only if -o is given")
      ->group(output);
  line.add_option("--stats", call.stats,
                  "write times, counts and bytes as JSON; - is the standard output")
      ->type_name("FILE")
      ->group(output);
  CLI::Option* verbose =
      line.add_flag("-v,--verbose", call.verbose, "print times, counts and bytes")->group(output);
  line.add_flag("-q,--quiet", call.quiet, "print errors only")->excludes(verbose)->group(output);
}

bool parse(RenderCall& call, Arguments arguments) {
  CommandLine line("render", "Renders a .vdb to a picture, without a window.");
  add_outputs(line, call);
  line.add_flag("--list-devices", call.list_devices, "print the EGL devices and exit");
  call.scene.add_to(line);
  line.add_option("--time-budget", call.time_budget,
                  "choose the most accurate method expected to march in MS milliseconds here")
      ->type_name("MS")
      ->check(number_in<double>({.min = 0, .min_open = true}))
      ->group(group_name(ParameterGroup::accuracy));
  line.add_option("--check-error", call.check_error,
                  "compare N pixels with the reference integrator and print the error")
      ->type_name("N")
      ->check(number_in<int>({.min = 1}))
      ->group(group_name(ParameterGroup::accuracy));
  return line.read(arguments);
}

/// Why the scene's picture cannot have a layer; empty if it can.
std::string layer_obstacle(const std::string& layer, const Scene& scene) {
  if (layer == "depth" && scene.mode == Mode::back_to_front)
    return "--aov depth is where a ray's transmittance falls below 1/2 from the camera on, which "
           "--mode back-to-front does not follow; take --mode alpha";
  if (layer == "error" && scene.mode == Mode::slice)
    return "--mode slice does not march: it has no error to estimate";
  const bool reference = scene.renderer == RendererKind::reference;
  if (reference && layer != "transmittance" && layer != "error")
    return "--aov " + layer + " is not available with --renderer " +
           parameter_text(scene, *find_parameter("renderer"));
  return {};
}

void check_layers(const RenderCall& call, const Scene& scene) {
  if (scene.mode == Mode::slice && (call.check_error || call.explain))
    usage("--mode slice does not march: it has no error to estimate, and nothing to explain");
  for (const std::string& layer : call.layers) {
    const std::string obstacle = layer_obstacle(layer, scene);
    if (!obstacle.empty()) usage(obstacle);
  }
}

/// Without --aov, the layers of --scene's picture that the output can have.
void take_layers(RenderCall& call, const Scene& scene) {
  const bool given = !call.layers.empty();
  std::erase(call.layers, "none");
  if (given || !holds_layers(call.output)) return;
  const std::vector<std::string> known = known_layers();
  for (const std::string& layer : call.scene.layers())
    if (std::find(known.begin(), known.end(), layer) != known.end() &&
        layer_obstacle(layer, scene).empty())
      call.layers.push_back(layer);
}

/// Makes every check that needs no work.
void check(const RenderCall& call, const Scene& scene) {
  if (call.time_budget) {
    if (scene.tolerance) usage("--time-budget and --tolerance exclude each other");
    if (scene.renderer == RendererKind::reference)
      usage("--time-budget is for a march; --renderer reference does not march");
    check_method_unset(scene, "--time-budget");
  }
  check_layers(call, scene);
  if (call.output.empty()) {
    const bool of_volume = call.explain || !call.camera.empty();
    if (!call.print_scene && !of_volume) usage("no output; give -o FILE.exr or -o FILE.png");
    if (of_volume && scene.input.empty()) usage("no input; give IN.vdb");
    return;
  }
  if (scene.input.empty()) usage("no input; give IN.vdb");
  if (is_standard_output(call.output) &&
      (call.print_scene || call.explain || call.check_error || call.stats == "-"))
    usage("-o " + call.output +
          " has the standard output for itself; leave out --print-scene, --explain, --check-error "
          "and --stats -");
  check_writable(call.output, call.format, scene.resolution.x, scene.resolution.y);
  const int code_bytes = holds_layers(call.output) ? 0 : call.format.bits == 16 ? 8 : 4;
  check_picture_memory(scene.resolution.x, scene.resolution.y, int(call.layers.size()), code_bytes);
  if (!call.layers.empty() && !holds_layers(call.output)) usage("--aov needs an .exr as output");
  if (!call.stats.empty()) check_text_writable(call.stats);
}

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

/// Whether a look's background is wanted: not where a picture may be composited as it is.
bool shows_background(const std::string& output) {
  return !output.empty() && !holds_layers(output) && !output.ends_with(".tif");
}

/// Opens the marcher while the file is read. get() throws the marcher's error.
using FutureMarcher = std::future<std::shared_ptr<Marcher>>;

/// Computing the light takes half of the bar; stages after the march take none.
StageProgress on_bar(const Progress& bar, bool lit) {
  if (!bar) return {};
  const double light_share = lit ? 0.5 : 0;
  return [=](Stage stage, double fraction) {
    if (stage == Stage::lighting) bar(fraction * light_share);
    if (stage == Stage::marching) bar(light_share + fraction * (1 - light_share));
  };
}

Wish wish_of(const RenderCall& call) {
  Wish wish;
  for (const auto& [name, member] : layer_names) wish.layers.*member = wants(call, name);
  wish.count = call.verbose || !call.stats.empty();
  wish.time_budget_ms = call.time_budget;
  return wish;
}

Drawn draw(const RenderCall& call, Session& session, Marcher& marcher) {
  ProgressBar bar(call.quiet);
  Wish wish = wish_of(call);
  wish.progress = on_bar(bar.progress(), session.view().medium.light.has_value());
  return session.draw(marcher, wish);
}

void composite(Image& image, const glm::dvec3& background) {
  const auto rgba = image.rgba();
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    const double behind = 1 - static_cast<double>(rgba[i + 3]);
    for (int c = 0; c < 3; ++c) {
      float& value = rgba[i + static_cast<std::size_t>(c)];
      value = static_cast<float>(static_cast<double>(value) + behind * background[c]);
    }
    rgba[i + 3] = 1;
  }
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

/// How the output shows radiance, and the scene with the exposure that `auto` chose.
Display display_of(const RenderCall& call, const Image& image, Scene& scene) {
  if (!holds_codes(call.output, call.format)) return {};
  if (!scene.exposure) {
    scene.exposure = auto_exposure(image, scene.tone_map);
    if (!call.quiet)
      std::fprintf(stderr, "psivox: exposure %s [powers of 2], chosen by auto\n",
                   number_text(*scene.exposure).c_str());
  }
  return {*scene.exposure, scene.tone_map};
}

void say_clipping(const RenderReport& report, const Scene& scene) {
  const double share = double(report.clipped) / double(report.drawn.image.rgba().size() / 4);
  if (share <= 0.01) return;
  std::string advice = "--exposure auto";
  if (scene.tone_map == ToneMap::none) advice += ", perhaps with --tone-map filmic,";
  std::fprintf(stderr, "psivox: %s of the pixels are brighter than white; %s shows their light\n",
               percent_text(share).c_str(), advice.c_str());
}

void add_color_bar(const RenderCall& call, const View& view, const Display& display, Image& image) {
  if (!view.scene.color_bar || !holds_codes(call.output, call.format)) return;
  const std::optional<ColorScale> scale = color_scale(view);
  const char* obstacle = !scale ? "--color-bar: the transfer function has no colours"
                         : draw_color_bar(image, *scale, display)
                             ? nullptr
                             : "--color-bar: the picture is too small for it";
  if (obstacle && !call.quiet) std::fprintf(stderr, "psivox: %s\n", obstacle);
}

void write(const RenderCall& call, const View& view, RenderReport& report) {
  Image& image = report.drawn.image;
  Scene scene = view.scene;
  WriteOptions format = call.format;
  format.display = display_of(call, image, scene);
  if (scene.background) composite(image, *scene.background);
  add_color_bar(call, view, format.display, image);
  add_scene(scene, call.layers, call.output, image.metadata);
  image.metadata["psivox:version"] = PSIVOX_VERSION;
  image.metadata["psivox:renderer"] = report.drawn.stats.renderer;
  constexpr double long_write = 5e7;  // [pixels]; some seconds
  if (!call.quiet && double(image.width) * image.height > long_write)
    std::fprintf(stderr, "psivox: writing %s\n", in_quotes(call.output).c_str());
  const Stopwatch writing;
  const std::string lost = write_image(image, call.output, format);
  report.write_ms = writing.ms();
  report.clipped = clipping(image, call.output, format).clipped;
  if (!call.quiet) {
    if (!lost.empty()) std::fprintf(stderr, "psivox: %s\n", lost.c_str());
    say_clipping(report, scene);
  }
  std::error_code not_a_file;
  const std::uintmax_t written = std::filesystem::file_size(call.output, not_a_file);
  report.output_bytes = not_a_file ? 0 : written;
}

void render(const RenderCall& call, Session& session, FutureMarcher opened, RenderReport& report) {
  const std::shared_ptr<Marcher> marcher = opened.get();
  report.drawn = draw(call, session, *marcher);
  if (!call.quiet) print_notices(report.drawn.notices);
  if (call.check_error) print_check(call, session, report);
  const std::string blank = blank_reason(session.view(), report.drawn.image);
  if (!blank.empty() && !call.quiet) std::fprintf(stderr, "psivox: %s\n", blank.c_str());
  write(call, session.view(), report);
}

}  // namespace

void render_command(Arguments arguments) {
  RenderReport report;
  report.startup_ms = process_ms();
  RenderCall call;
  if (!parse(call, arguments)) return;
  if (call.list_devices) return print_devices();
  Scene scene = call.scene.scene();
  take_layers(call, scene);
  check(call, scene);
  if (!call.time_budget) scene = with_default_tolerance(scene);
  if (scene.input.empty()) {  // only with --print-scene
    std::cout << to_json(scene);
    return;
  }

  report.input = scene.input;
  report.output = call.output;
  FutureMarcher opened;
  if (!call.output.empty())
    opened = std::async(std::launch::async, [&scene] { return open_marcher(scene); });
  const Stopwatch reading;
  const LookedScene looked =
      with_look(scene, VdbFile(scene.input), "auto", shows_background(call.output));
  if (!call.quiet) print_look(looked);
  scene = looked.scene;
  Session session(make_view(scene, looked.fields));
  report.read_ms = reading.ms();
  if (!call.quiet) print_notices(session.view(), scene);
  if (call.print_scene) std::cout << to_json(session.view().scene) << std::flush;
  if (!call.camera.empty())
    write_camera(call.camera, session.view().camera,
                 z_is_up(session.view().scene, *session.view().subject));
  if (call.explain) print_explanation(session);
  if (call.output.empty()) return;

  render(call, session, std::move(opened), report);
  report.total_ms = process_ms();
  if (!call.stats.empty()) write_text(call.stats, report.json());
  if (call.verbose) std::fputs(report.table().c_str(), stderr);
}

}  // namespace psivox
