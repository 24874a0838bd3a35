// psivox study IN.vdb -o DIR: measures error and time of many methods for one scene.

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/command_text.h"
#include "base/text.h"
#include "base/text_file.h"
#include "notices.h"
#include "psivox/open.h"
#include "psivox/sequence.h"
#include "psivox/study.h"
#include "psivox/vdb.h"
#include "render_call.h"
#include "scene/json_problem.h"

namespace psivox {
namespace {

/// The contents of the file that `--study FILE` names.
struct StudyFile {
  Sweep sweep;
  Scene scene;
  int repeats = 0;  ///< 0: not given
};

inline constexpr Range repeats_range{1, 1000};

using nlohmann::json;

/// A list in the command line's syntax.
std::string list_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const json& item : value) text += (text.empty() ? "" : ",") + list_text(item);
  return text;
}

int repeats_of(const json& value) {
  if (!value.is_number_integer() || !repeats_range.contains(value.get<double>()))
    usage("repeats " + value.dump() + ": expected a whole number" + repeats_range.text());
  return value.get<int>();
}

/// Reads a JSON object: the sweep's lists by name, as arrays or in the command line's syntax;
/// `repeats`; and `scene`, an object in the format of --scene. Throws Error(input), Error(usage).
StudyFile read_study_file(const std::string& path) {
  const std::string text = read_text(path, "study");
  StudyFile file;
  try {
    const json object = parsed_json(text, "a study", ExitCode::usage);
    if (!object.is_object()) usage("not a study: expected a JSON object");
    for (const auto& [name, value] : object.items())
      if (name == "scene")
        file.scene = scene_from_json(value.dump(), "scene");
      else if (name == "repeats")
        file.repeats = repeats_of(value);
      else
        set_sweep(file.sweep, name, list_text(value));
  } catch (const Error& error) {
    usage(path + ": " + error.what());
  }
  return file;
}

struct StudyCall {
  SceneOptions scene;
  FrameOptions sequence;
  std::map<std::string, std::optional<std::string>> lists;  ///< the sweep's, as given
  std::string output, file, camera_for, peers;
  std::vector<std::string> added;  ///< NAME=PICTURE[,TIME_MS]
  std::optional<int> repeats;
  std::string suite;  ///< its size; empty: none
  bool no_split = false, resume = false, quiet = false;
};

bool parse(StudyCall& call, Arguments arguments) {
  CommandLine line(
      "study",
      "Renders a volume by many methods and measures the error and time of each. Writes "
      "numbers, pictures and a page with tables and plots.",
      {"output", "integrators", "steps", "add", "camera-for", "resume", "quiet"},
      {"smoke.vdb -o study", "smoke.vdb -o study --resume --add 'cycles 1=cycles.exr,2050'",
       "smoke.vdb -o study --resolution 256x256 --integrators psi-weighted,cell-exact"});
  line.add_value("-o,--output", call.output, "DIR", "folder for the results; created if missing");
  for (const auto& [name, help, usual] : sweep_lists())
    line.add_value("--" + name, call.lists[name], "LIST", help)
        ->default_str(usual.empty() ? "none" : usual);
  line.add_value("--repeats", call.repeats, "N", "timed runs of each method; the median counts")
      ->check(number_in<int>(repeats_range))
      ->default_str(number_text(StudyOptions{}.repeats));
  line.add_value("--study", call.file, "FILE",
                 "read the lists above, repeats and scene from a .json; the command line "
                 "overrides them");
  line.add_flag("--no-split", call.no_split,
                "do not split the error into step error and arithmetic error; saves most of the "
                "time");
  line.add_flag("--resume", call.resume, "continue the study in DIR");
  line.add_value("--add", call.added, "NAME=PICTURE[,TIME_MS]",
                 "another renderer's picture of the scene, and its time if known; repeat for more")
      ->allow_extra_args(false)
      ->take_all();
  line.add_value("--peers", call.peers, "FILE",
                 "read a list of such pictures from a .json: objects with name, picture, time_ms");
  line.add_value("--camera-for", call.camera_for, "NAME",
                 "print the camera for another renderer: " + joined(camera_line_formats(), ", ") +
                     "; nothing else")
      ->check(one_of(camera_line_formats()));
  line.add_value("--suite", call.suite, "[SIZE]",
                 "measure the precision suite, small or full, without a volume; exits with 7 if "
                 "an order of convergence or an error is not as expected")
      ->expected(0, 1)
      ->default_str("small")
      ->check(one_of<std::string>({"small", "full"}));
  line.add_flag("-q,--quiet", call.quiet, "print errors only");
  call.sequence.add_to(line);
  std::vector<std::string> without = swept_parameters();
  without.emplace_back("input");
  call.scene.add_to(line, without);
  if (!line.read(arguments)) return false;
  if (call.output.empty() && call.camera_for.empty()) usage("--output is required");
  if (call.output == "-") usage("a study is a folder; give -o DIR");
  if (!call.sequence.inputs.empty()) call.scene.set("input", call.sequence.inputs.front());
  return true;
}

StudyOptions options_of(const StudyCall& call, const StudyFile& file) {
  StudyOptions options;
  options.folder = call.output;
  options.sweep = file.sweep;
  for (const auto& [name, text] : call.lists)
    if (text) set_sweep(options.sweep, name, *text);
  if (file.repeats) options.repeats = file.repeats;
  if (call.repeats) options.repeats = *call.repeats;
  options.split = !call.no_split;
  options.resume = call.resume;
  if (!call.peers.empty()) options.foreign = read_foreign_pictures(call.peers);
  for (const std::string& text : call.added) options.foreign.push_back(foreign_picture(text));
  return options;
}

volatile std::sig_atomic_t interrupted = 0;

/// Ctrl-C asks the study to stop; a second one ends the program at once.
void stop_on_interrupt() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
}

void print_camera(const Scene& scene, const std::string& renderer) {
  const OpenedScene opened = open_scene(scene, VolumeFile(scene.input));
  std::cout << camera_lines(opened.view, renderer);
}

/// Studies each frame in a folder of its own, in one scene, and then all of them together. Returns
/// the conclusion.
std::string study_frames(const StudyCall& call, const Scene& scene, const FrameList& list,
                         StudyOptions options, ProgressBar& bar) {
  const std::filesystem::path folder = options.folder;
  check_study_folder(folder, options.resume);
  const SequenceScene sequence = chosen_for(list, scene, true, list.others_serve);
  if (!call.quiet) print_choice(sequence, list);
  const Progress progress = bar.progress();
  std::vector<StudiedFrame> studied;
  for (const Frame& frame : list.frames) {
    OpenedScene opened = open_frame(sequence, VolumeFile(frame.input), frame.input);
    if (opened.looked.fields.density->active_voxels == 0) continue;
    options.folder = folder / formatted("frame.%04lld", static_cast<long long>(frame.number));
    if (progress)
      options.progress = [&, done = double(&frame - list.frames.data())](double fraction) {
        progress((done + fraction) / double(list.frames.size()));
      };
    run_study(std::move(opened.view), options);
    studied.push_back({frame.number, options.folder});
  }
  return write_frame_statistics(studied, folder);
}

}  // namespace

void study_command(Arguments arguments) {
  StudyCall call;
  if (!parse(call, arguments)) return;
  if (!call.suite.empty() && !(call.added.empty() && call.peers.empty() && call.camera_for.empty()))
    usage("--add, --peers and --camera-for need a scene; --suite has its own");
  ProgressBar bar(call.quiet);
  const auto conclude = [&](const std::string& conclusion) {
    bar.clear();
    if (!call.quiet) std::cout << conclusion << '\n';
  };
  if (!call.suite.empty())
    return conclude(
        run_suite(call.output, call.suite == "full", call.scene.scene({}).device, bar.progress()));
  const StudyFile file = call.file.empty() ? StudyFile{} : read_study_file(call.file);
  StudyOptions options = options_of(call, file);
  const Scene scene = call.scene.scene(file.scene);
  check_one_volume(scene, "study");
  if (scene.input.empty()) usage("no input; give IN.vdb");
  std::vector<std::string> inputs = call.sequence.inputs;
  if (inputs.empty()) inputs.push_back(scene.input);
  stop_on_interrupt();
  options.stop = [] { return interrupted != 0; };
  const auto files = sequence_files(inputs, !call.sequence.frames.empty());
  if (files && !(options.foreign.empty() && call.camera_for.empty()))
    usage("--add, --peers and --camera-for are for one frame; give its file");
  if (!call.camera_for.empty()) return print_camera(scene, call.camera_for);
  if (files)
    return conclude(study_frames(call, scene, list_files(call.sequence, *files), options, bar));
  check_foreign(options, scene);
  check_study_folder(options.folder, options.resume);
  OpenedScene opened = open_scene(scene, VolumeFile(scene.input));
  if (!call.quiet) {
    options.say = [&](const std::string& text) { bar.say(text); };
    print_look(opened.looked, false);
    print_choices(opened, false);
    options.say("the scene: " +
                render_command_line(studied_scene(opened.view.scene), "picture.png"));
  }
  options.progress = bar.progress();
  conclude(run_study(std::move(opened.view), options));
}

}  // namespace psivox
