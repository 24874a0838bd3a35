// psivox render IN.vdb -o OUT.exr: the main job.

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
#include "march_choice.h"
#include "notices.h"
#include "progress_bar.h"
#include "psivox/error.h"
#include "psivox/error_control.h"
#include "psivox/explain.h"
#include "psivox/image.h"
#include "psivox/light.h"
#include "psivox/medium.h"
#include "psivox/reference.h"
#include "psivox/renderer.h"
#include "psivox/text.h"
#include "psivox/text_file.h"
#include "psivox/vdb.h"
#include "render_report.h"
#include "scene_options.h"

namespace psivox {
namespace {

const std::vector<std::string> known_layers = {"depth", "transmittance", "steps", "samples",
                                               "error"};

struct RenderCall {
  SceneOptions scene;
  std::string output, stats;
  std::vector<std::string> layers;    ///< that --aov names
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
                  "picture to write: .exr (linear, premultiplied) or .png (sRGB)")
      ->type_name("FILE")
      ->group(output);
  line.add_list("--aov", call.layers, "extra layers of the .exr: " + joined(known_layers, ", "))
      ->check(CLI::IsMember(known_layers).description(""))
      ->group(output);
  line.add_flag("--half", call.format.half, "store the .exr in 16-bit floats")->group(output);
  line.add_option("--bits", call.format.bits, "bits per channel of the .png")
      ->type_name("8|16")
      ->default_str("8")
      ->check(CLI::IsMember({8, 16}).description(""))
      ->group(output);
  line.add_flag("--print-scene", call.print_scene,
                "print the complete scene as JSON; render only if -o is given")
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
  CommandLine line("render", "Renders a .vdb to an EXR or PNG file, without a window.");
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

void check_layers(const RenderCall& call, const Scene& scene) {
  const bool reference = scene.renderer == RendererKind::reference;
  if (wants(call, "depth") && scene.mode == Mode::back_to_front)
    usage(
        "--aov depth is where a ray's transmittance falls below 1/2 from the camera on, which "
        "--mode back-to-front does not follow; take --mode alpha");
  for (const std::string& layer : call.layers) {
    if (reference && layer != "transmittance" && layer != "error")
      usage("--aov " + layer + " is not available with --renderer " +
            parameter_text(scene, *find_parameter("renderer")));
  }
}

/// All that can be refused before any work.
void check(const RenderCall& call, const Scene& scene) {
  if (call.time_budget) {
    if (scene.tolerance) usage("--time-budget and --tolerance exclude each other");
    if (scene.renderer == RendererKind::reference)
      usage("--time-budget is for a march; --renderer reference does not march");
    check_method_unset(scene, "--time-budget");
  }
  check_layers(call, scene);
  if (call.output.empty()) {
    if (!call.print_scene && !call.explain) usage("no output; give -o FILE.exr or -o FILE.png");
    if (call.explain && scene.input.empty()) usage("no input; give IN.vdb");
    return;
  }
  if (scene.input.empty()) usage("no input; give IN.vdb");
  check_writable(call.output, call.format);
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

/// The part of a whole that goes from `first` to `last`.
Progress part_of(const Progress& whole, double first, double last) {
  if (!whole) return {};
  return [=](double fraction) { whole(first + fraction * (last - first)); };
}

/// Computes the view's light and adds it to the atlas.
void add_light(View& view, MediumAtlas& atlas, const LightDepths& depths, const Progress& progress,
               RenderReport& report) {
  const Stopwatch lighting;
  view = lit(std::move(view), depths, progress);
  add_luminance(atlas, view);
  report.light_ms = lighting.ms();
}

/// `common`: RMS by which both pictures are off alike.
void add_error(Image& image, const Image& exact, double common, RenderReport& report) {
  report.difference = compare_images(image, exact);
  report.difference->rms = std::hypot(report.difference->rms, common);
  image.layers.push_back(error_layer(image, exact, common));
}

/// Made while the file is read. Throws, on get(), what GlRenderer's constructor does.
using FutureRenderer = std::future<std::unique_ptr<GlRenderer>>;

FutureRenderer open_renderer(const Scene& scene) {
  if (scene.renderer != RendererKind::gl) return {};
  return std::async(std::launch::async, [device = scene.device] {
    return std::make_unique<GlRenderer>(ContextOptions{device});
  });
}

Image march(const RenderCall& call, View& view, FutureRenderer opened, const Progress& whole,
            RenderReport& report) {
  const Stopwatch building;
  MediumAtlas atlas = build_medium_atlas(view);
  report.atlas_ms = building.ms();
  const bool light = view.medium.light.has_value();
  const Progress progress = part_of(whole, light ? 0.5 : 0, 1);
  const Progress light_progress = part_of(whole, 0, 0.5);

  const bool count =
      call.verbose || !call.stats.empty() || wants(call, "steps") || wants(call, "samples");
  const RenderOptions render{count, wants(call, "depth"), wants(call, "transmittance"), progress};
  RenderResult result;
  View marched;
  if (view.scene.renderer == RendererKind::march_double) {
    if (light)
      add_light(view, atlas, march_double_light_depths(view, atlas), light_progress, report);
    marched = choose_march(view, atlas, call.time_budget, nullptr, call.quiet, report);
    const Stopwatch marching;
    result = render_march_double(marched, atlas, render);
    result.stats.march_ms = marching.ms();
    if (wants(call, "error"))
      add_error(result.image, render_march_double(exact_view(marched), atlas).image, 0, report);
  } else {
    const std::unique_ptr<GlRenderer> renderer = opened.get();
    if (light) {
      renderer->upload(atlas);
      add_light(view, atlas, renderer->light_depths(view), light_progress, report);
    }
    renderer->upload(atlas, view.scene.filter);
    marched = choose_march(view, atlas, call.time_budget, renderer.get(), call.quiet, report);
    result = renderer->render(marched, render);
    if (report.plan) confirm_plan(*renderer, render, call.quiet, report);
    if (wants(call, "error")) {
      if (view.scene.filter != Filter::exact) renderer->upload(atlas);
      const View exact = exact_view(marched);
      const Image picture = renderer->render(exact).image;
      add_error(result.image, picture,
                device_error(exact, atlas, renderer->render(pilot_view(exact)).image), report);
    }
  }
  report.stats = result.stats;
  report.atlas = atlas.size();
  return std::move(result.image);
}

Image integrate(const RenderCall& call, View& view, const Progress& progress,
                RenderReport& report) {
  const bool light = view.medium.light.has_value();
  if (light) {
    const Stopwatch lighting;
    view = lit(view, reference_light_depths(view), part_of(progress, 0, 0.5));
    report.light_ms = lighting.ms();
  }
  ReferenceResult result = render_reference(view, 1e-12, part_of(progress, light ? 0.5 : 0, 1));
  report.stats.renderer = "reference, adaptive quadrature in double precision on the CPU";
  report.stats.rays = static_cast<std::uint64_t>(result.image.width) *
                      static_cast<std::uint64_t>(result.image.height) *
                      static_cast<std::uint64_t>(view.scene.pixel_samples);
  report.stats.march_ms = 1e3 * result.seconds;
  report.reference_cells = result.cells;
  if (wants(call, "transmittance")) {
    Layer layer{"transmittance", {"transmittance"}, {}};
    const auto rgba = result.image.rgba();
    for (std::size_t i = 3; i < rgba.size(); i += 4) layer.values.push_back(1 - rgba[i]);
    result.image.layers.push_back(std::move(layer));
  }
  return std::move(result.image);
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

void print_explanation(const View& view) {
  const MediumAtlas atlas = build_medium_atlas(view);
  // the light that the choice waits for is a picture's work
  const bool plan = view.scene.tolerance && !view.medium.light;
  const View marched = plan ? plan_march(view, atlas).view : view;
  if (view.scene.tolerance && !plan)
    std::printf("%-16s %s\n", "tolerance", "sampling and rule are chosen when the light is known");
  for (const Choice& choice : explain(marched, atlas))
    std::printf("%-16s %s\n", choice.what.c_str(), choice.text.c_str());
}

/// Compares with the reference, on the standard output.
void print_check(const RenderCall& call, const View& view, const Image& image,
                 RenderReport& report) {
  ProgressBar bar(call.quiet);
  report.checked = check_error(view, image, std::min(*call.check_error, 100000000), bar.progress());
  std::printf("error     RMS %.2e, max %.2e at %d,%d: %d pixels against the reference\n",
              report.checked->rms, report.checked->max, report.checked->max_x,
              report.checked->max_y, report.checked->pixels);
  if (report.plan)
    std::printf("estimate  RMS %.2e, max %.2e: %s\n", report.plan->chosen.rms,
                report.plan->chosen.max, trial_text(report.plan->chosen).c_str());
}

void render(const RenderCall& call, View& view, FutureRenderer opened, RenderReport& report) {
  Image image;
  {
    ProgressBar bar(call.quiet);
    image = view.scene.renderer == RendererKind::reference
                ? integrate(call, view, bar.progress(), report)
                : march(call, view, std::move(opened), bar.progress(), report);
  }
  if (call.check_error) print_check(call, view, image, report);
  // Counting makes layers that nobody may have asked for.
  std::erase_if(image.layers, [&](const Layer& layer) {
    return !layer.name.empty() && !wants(call, layer.name.c_str());
  });
  if (view.scene.background) composite(image, *view.scene.background);
  image.metadata["psivox:scene"] = to_json(view.scene);
  image.metadata["psivox:version"] = PSIVOX_VERSION;
  image.metadata["psivox:renderer"] = report.stats.renderer;

  const Stopwatch writing;
  write_image(image, call.output, call.format);
  report.write_ms = writing.ms();
}

}  // namespace

void render_command(Arguments arguments) {
  RenderReport report;
  report.startup_ms = process_ms();
  RenderCall call;
  if (!parse(call, arguments)) return;
  if (call.list_devices) return print_devices();
  Scene scene = call.scene.scene();
  check(call, scene);
  if (!call.time_budget) scene = with_default_tolerance(scene);
  if (scene.input.empty()) {  // only --print-scene comes here
    std::cout << to_json(scene);
    return;
  }

  report.input = scene.input;
  report.output = call.output;
  FutureRenderer opened;
  if (!call.output.empty()) opened = open_renderer(scene);
  const Stopwatch reading;
  View view = make_view(scene, VdbFile(scene.input));
  report.read_ms = reading.ms();
  if (!call.quiet) print_notices(view, !scene.extinction && scene.attenuates());
  if (call.print_scene) std::cout << to_json(view.scene) << std::flush;
  if (call.explain) print_explanation(view);
  if (call.output.empty()) return;

  render(call, view, std::move(opened), report);
  std::error_code not_a_file;
  const std::uintmax_t written = std::filesystem::file_size(call.output, not_a_file);
  report.output_bytes = not_a_file ? 0 : written;
  report.total_ms = process_ms();
  if (!call.stats.empty()) write_text(call.stats, report.json());
  if (call.verbose) std::fputs(report.table().c_str(), stderr);
}

}  // namespace psivox
