#include "render_call.h"

#include <algorithm>
#include <filesystem>

#include "base/input_file.h"
#include "psivox/open.h"
#include "psivox/vdb.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

const CLI::Validator above_zero = number_in<double>({.min = 0, .min_open = true});

void add_outputs(CommandLine& line, RenderCall& call) {
  line.begin_group(group_name(ParameterGroup::output));
  line.add_value("-o,--output", call.output, "FILE",
                 "picture to write: .exr or .tif (linear, premultiplied), .png (sRGB); without "
                 "alpha: .jpg or .webp (sRGB), .hdr (linear); .html: a page on which it turns");
  std::vector<std::string> layers = layer_names();
  layers.emplace_back("none");
  line.add_list("--aov", call.layers,
                "extra layers of the .exr: " + joined(layer_names(), ", ") +
                    " makes it a deep .exr; none drops the layers of --scene's picture")
      ->check(one_of(layers));
  line.add_value("--thumbnail", call.thumbnail, "N",
                 "make a picture of NxN pixels for a file manager: exact enough for 8 bits, "
                 "within 1 GiB of memory and 20 s; .png if -o names no format")
      ->check(number_in<int>({.min = 1, .max = 4096}));
  line.add_value("--credit", call.page.credit, "TEXT", "line below the picture of an .html");
  line.add_value("--page-limit", call.page.limit_mb, "MB", "largest .html")
      ->check(above_zero)
      ->capture_default_str();
  line.add_flag("--half", call.format.half, "store the .exr in 16-bit floats");
  line.add_value("--bits", call.format.bits, "8|16",
                 "bits per channel of a .png (default: 8) or of a .tif, which then is sRGB instead "
                 "of linear 32-bit floats")
      ->check(one_of<int>({8, 16}));
  line.add_flag("--print-scene", call.print_scene,
                "print the complete scene as JSON; render only if -o is given");
  line.add_value("--export-camera", call.camera, "FILE",
                 "write the camera as .gltf (Blender reads it) or ParaView's .pvcc; render only if "
                 "-o is given");
  line.add_flag("--explain", call.explain,
                "print what the march computes and skips, and why; render only if -o is given");
  line.add_value("--stats", call.stats, "FILE",
                 "write times, counts and bytes as JSON; - is the standard output");
  CLI::Option* verbose = line.add_flag("-v,--verbose", call.verbose,
                                       "print the look's options, times, counts and bytes");
  line.add_flag("-q,--quiet", call.quiet, "print errors only")->excludes(verbose);
}

void add_frames(CommandLine& line, RenderCall& call) {
  call.sequence.add_to(line);
  line.add_value("--turntable", call.turntable, "N",
                 "turn the camera around the volume in N pictures; along a sequence, in N frames")
      ->check(number_in<int>({.min = 1}));
  line.add_value("--camera-path", call.camera_path, "FILE[:NAME]",
                 "camera of each frame: key frames in a .json, or the animation of a .gltf or "
                 ".glb");
  line.add_flag("--follow", call.follow, "keep the volume in the middle of each frame");
  line.add_flag("--resume", call.resume,
                "leave out frames whose picture is there, whole, of the same scene and format, and "
                "not older than its files");
  line.add_flag("--keep-going", call.keep_going,
                "go on after a frame that cannot be read; the exit code is then 3");
  line.add_value("--movie", call.movie, "FILE.mp4",
                 "write the frames as a film too, through ffmpeg");
  line.add_value("--fps", call.frame_rate, "N", "frames per second of --movie and --camera-path")
      ->check(above_zero)
      ->capture_default_str();
}

/// What gives the picture that vdb_render takes as its last argument, or any.
std::string likely_output(const RenderCall& call) {
  const std::vector<std::string>& inputs = call.sequence.inputs;
  if (inputs.size() > 1 && has_picture_extension(inputs.back()))
    return "-o " + shell_word(inputs.back());
  return "-o FILE.exr or -o FILE.png";
}

/// Throws Error(usage) for what a page has not, and where nothing else is a page.
void check_page_call(const RenderCall& call, const Scene& scene) {
  if (!is_page_name(call.output)) {
    if (!call.page.credit.empty()) usage("--credit is for a page, -o FILE.html");
    if (call.page.limit_mb != PageOptions{}.limit_mb)
      usage("--page-limit is for a page, -o FILE.html");
    return;
  }
  if (const std::string obstacle = page_obstacle(scene); !obstacle.empty()) usage(obstacle);
  if (call.turntable || !call.camera_path.empty() || !call.movie.empty() ||
      !call.sequence.frames.empty() || FramePattern::of_placeholder(call.output))
    usage("a page (.html) shows one volume, not a sequence");
  if (!call.layers.empty()) usage("--aov needs an .exr as output");
  if (call.format.half || call.format.bits)
    usage("--half and --bits are for pictures, not for a page");
}

bool is_file(const std::string& path) { return !path.empty() && path != "-"; }

/// Devices such as /dev/null keep nothing that could be lost.
bool same_file(const std::string& a, const std::string& b) {
  if (!is_file(a) || !is_file(b)) return false;
  std::error_code missing;
  if (fs::exists(a, missing) && fs::exists(b, missing))
    return fs::is_regular_file(a, missing) && fs::equivalent(a, b, missing);
  return fs::weakly_canonical(a, missing) == fs::weakly_canonical(b, missing);
}

}  // namespace

bool parse(RenderCall& call, Arguments arguments) {
  CommandLine line("render",
                   "Renders a volume (.vdb, NIfTI, NRRD) to a picture, without a window. Under "
                   "mpirun several processes draw it together, in every mode but slice and "
                   "back-to-front; no sequences.",
                   {"output", "frames", "turntable", "movie", "verbose"},
                   {"smoke.vdb -o smoke.png",
                    "smoke.vdb -o smoke.exr --azimuth 30 --background white --tolerance 1e-4",
                    "'fire.####.vdb' -o 'fire.####.png' --movie fire.mp4"});
  line.add_flag("--list-devices", call.list_devices, "print the EGL devices and exit");
  add_outputs(line, call);
  add_frames(line, call);
  call.scene.add_to(line, {"input"});
  line.begin_group(group_name(ParameterGroup::accuracy));
  line.add_value("--check-error", call.check_error, "N",
                 "compare N pixels with the reference integrator and print the error")
      ->check(number_in<int>({.min = 1}));
  if (!line.read(arguments)) return false;
  if (!call.sequence.inputs.empty()) call.scene.set("input", call.sequence.inputs.front());
  return true;
}

void take_layers(RenderCall& call, const Scene& scene) {
  const bool given = !call.layers.empty();
  std::erase(call.layers, "none");
  if (given || !holds_layers(call.output)) return;
  for (const std::string& layer : call.scene.layers())
    if (std::ranges::count(layer_names(), layer) && layer_obstacle(layer, scene).empty())
      call.layers.push_back(layer);
}

void check(const RenderCall& call, const Scene& scene) {
  check_page_call(call, scene);
  check_picture(scene, call.layers);
  if (scene.shows(Shows::plane) && (call.check_error || call.explain))
    usage("--mode slice does not march: it has no error to estimate, and nothing to explain");
  if (call.frame_rate != RenderCall{}.frame_rate && call.movie.empty() && call.camera_path.empty())
    usage("--fps is for --movie and --camera-path");
  if (call.follow && !call.camera_path.empty())
    usage("--follow moves the camera, and so does --camera-path: leave one of them out");
  if (!call.camera.empty() && (call.follow || !call.camera_path.empty()))
    usage("--export-camera writes one camera, and " +
          std::string(call.follow ? "--follow" : "--camera-path") + " moves it; leave it out");
  if (!scene.holdout.empty() && (call.turntable || !call.camera_path.empty() || call.follow) &&
      !FramePattern::of_placeholder(scene.holdout))
    usage(
        "--holdout has depths of one camera, which moves here; name a file for each frame, such as "
        "z.####.exr");
  for (const std::string& file : files_of(scene)) InputProtection::expect(frame_of_file(file).file);
  check_outputs(call, call.output);
  const bool draws = !call.output.empty() || !call.movie.empty();
  const bool of_volume = draws || call.explain || !call.camera.empty();
  if (scene.input.empty() && (of_volume || !call.print_scene)) usage("no input; give IN.vdb");
  if (!of_volume && !call.print_scene) usage("no output; give " + likely_output(call));
  if (!draws) return;
  if (is_standard_output(call.output) &&
      (call.print_scene || call.explain || call.check_error || call.stats == "-"))
    usage("-o " + call.output +
          " has the standard output for itself; leave out --print-scene, --explain, --check-error "
          "and --stats -");
  if (is_page_name(call.output))
    check_text_writable(call.output);
  else if (const std::string problem = extension_problem(call.output);
           !call.output.empty() && !problem.empty())
    usage(problem + ", or .html for a page");
  else if (!call.output.empty())
    check_writable(call.output, call.format, scene.resolution.x, scene.resolution.y);
  const int code_bytes = holds_layers(call.output) ? 0 : call.format.bits == 16 ? 8 : 4;
  check_picture_memory(scene.resolution.x, scene.resolution.y, int(call.layers.size()), code_bytes);
  if (call.format.half && std::ranges::count(call.layers, "deep"))
    usage("--half has too few digits for --aov deep; leave it out");
  if (call.format.half && std::ranges::count(call.layers, "bound"))
    usage("--half adds an error that --aov bound lacks; leave it out");
  if (!call.layers.empty() && !holds_layers(call.output)) usage("--aov needs an .exr as output");
  if (!call.stats.empty()) check_text_writable(call.stats);
}

Wish wish_of(const RenderCall& call) {
  Wish wish;
  wish.layers = layers_of(call.layers);
  wish.count = call.verbose || !call.stats.empty();
  wish.fewest_bytes = is_page_name(call.output);
  return wish;
}

void check_overwriting(std::span<const WrittenFile> written) {
  for (std::size_t n = 0; n < written.size(); ++n) {
    const auto& [option, path] = written[n];
    const std::string what = std::string(option) + " " + in_quotes(path);
    const std::string input = is_file(path) ? InputProtection::input_at(path) : "";
    if (!input.empty())
      usage(what + " is the input " + in_quotes(input) +
            ", which it would replace; give another name");
    for (const WrittenFile& other : written.first(n))
      if (same_file(path, other.path))
        usage(what + " is also the file of " + other.option + "; give another name");
  }
}

void check_outputs(const RenderCall& call, const std::string& picture) {
  const std::string& scene = call.scene.file();
  const bool renamed = call.thumbnail_name != call.output;
  const WrittenFile written[] = {{"-o", picture},
                                 {"--thumbnail", renamed ? call.thumbnail_name : ""},
                                 {"--movie", call.movie},
                                 {"--stats", call.stats},
                                 {"--export-camera", call.camera}};
  check_overwriting(written);
  // the picture of a scene may be drawn again in its place, and have no other file there
  for (const auto& [option, path] : std::span(written).subspan(1))
    if (same_file(path, scene))
      usage(std::string(option) + " " + in_quotes(path) + " is the input " + in_quotes(scene) +
            ", which it would replace; give another name");
}

}  // namespace psivox
