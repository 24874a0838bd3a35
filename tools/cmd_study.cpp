// psivox study IN.vdb -o DIR: error and time of many ways to render one scene.

#include <csignal>
#include <map>
#include <string>

#include "command_line.h"
#include "commands.h"
#include "notices.h"
#include "progress_bar.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "psivox/study.h"
#include "psivox/text.h"
#include "psivox/vdb.h"
#include "scene_options.h"
#include "study_file.h"

namespace psivox {
namespace {

struct StudyCall {
  SceneOptions scene;
  std::map<std::string, std::string> lists;  ///< of the sweep, as given
  std::string output, file, repeats, summary;
  bool psi = false, orders = false, no_split = false, resume = false, quiet = false;
};

bool parse(StudyCall& call, Arguments arguments) {
  CommandLine line("study",
                   "Renders a .vdb in many ways and measures error and time of each: tables, "
                   "plots and pictures in a folder, and a page that shows them.");
  line.add_value("--output", 'o', "DIR", "folder for the results; made where it is missing",
                 call.output);
  const std::map<std::string, std::pair<const char*, const char*>> help = {
      {"integrators", {"LIST", "rules, or all (default: all)"}},
      {"samplings", {"LIST", "of cells, uniform, template, or all (default: cells,uniform)"}},
      {"segments", {"LIST", "linear segments a cell, under cells (default: 1,2,4)"}},
      {"steps", {"LIST", "uniform steps [voxels] (default: 4,2,1,0.5,0.25)"}},
      {"filters", {"LIST", "of exact, hardware, or all (default: exact)"}},
      {"texels", {"LIST", "of float32, float16, or all (default: float32)"}},
      {"tolerances",
       {"LIST", "errors to ask for: each marched as --tolerance chooses (default: none)"}},
      {"resolutions", {"LIST", "of WxH [pixels] (default: --resolution's)"}}};
  for (const std::string& name : sweep_lists())
    line.add_value("--" + name, 0, help.at(name).first, help.at(name).second, call.lists[name]);
  line.add_value("--repeats", 0, "N", "times that each is timed; the median counts (default: 3)",
                 call.repeats);
  line.add_value("--study", 0, "FILE",
                 "the lists above, repeats and scene from a .json; the command line wins",
                 call.file);
  line.add_flag("--no-split", 0,
                "leave out the march in double, and with it the step error and the arithmetic "
                "error apart: most of a study's time",
                call.no_split);
  line.add_flag("--resume", 0, "go on with the study that DIR holds", call.resume);
  line.add_flag("--psi", 0, "study the rules themselves, without a volume", call.psi);
  line.add_flag("--orders", 0,
                "fit orders of convergence in step, voxel and pixel, without a volume",
                call.orders);
  line.add_value("--summary", 0, "DIR,...",
                 "what each rule needs for an error in finished studies, side by side",
                 call.summary);
  line.add_flag("--quiet", 'q', "print errors only", call.quiet);
  call.scene.add_to(line, swept_parameters());
  return line.parse(arguments);
}

StudyOptions options_of(const StudyCall& call, const StudyFile& file) {
  StudyOptions options;
  options.folder = call.output;
  options.sweep = file.sweep;
  for (const auto& [name, text] : call.lists)
    if (!text.empty()) set_sweep(options.sweep, name, text);
  if (file.repeats) options.repeats = file.repeats;
  if (!call.repeats.empty()) options.repeats = read_repeats(call.repeats);
  options.split = !call.no_split;
  options.resume = call.resume;
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

}  // namespace

void study_command(Arguments arguments) {
  StudyCall call;
  if (!parse(call, arguments)) return;
  if (call.output.empty()) usage("no output; give a folder with -o DIR");
  if (call.psi || call.orders) {
    if (call.psi && call.orders) usage("--psi and --orders are two studies; give one of them");
    ProgressBar bar(call.quiet);
    return (call.psi ? run_psi_study : run_order_study)(call.output, bar.progress());
  }
  if (!call.summary.empty()) {
    std::vector<std::filesystem::path> folders;
    for (const std::string& folder : split(call.summary)) folders.emplace_back(folder);
    return run_summary(folders, call.output);
  }
  const StudyFile file = call.file.empty() ? StudyFile{} : read_study_file(call.file);
  StudyOptions options = options_of(call, file);
  const Scene scene = call.scene.scene(file.scene);
  if (scene.input.empty()) usage("no input; give IN.vdb");
  check_study_folder(options.folder, options.resume);

  View view = make_view(scene, VdbFile(scene.input));
  if (!call.quiet) print_notices(view, !scene.extinction && scene.attenuates());
  stop_on_interrupt();
  ProgressBar bar(call.quiet);
  options.progress = bar.progress();
  options.stop = [] { return interrupted != 0; };
  run_study(std::move(view), options);
}

}  // namespace psivox
