
#include "render_call.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "base/input_file.h"
#include "base/text.h"
#include "notices.h"
#include "psivox/error.h"
#include "psivox/vdb.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

/// Numbers of the pictures of one file.
std::vector<FrameNumber> numbers_of_file(const RenderCall& call, const CameraPath* path) {
  if (!call.sequence.frames.empty()) return read_frames(call.sequence.frames, "--frames");
  const double first = path ? std::ceil(path->first()) : 1;
  const double count = call.turntable ? *call.turntable : std::floor(path->last()) - first + 1;
  if (count > most_frames)
    usage(std::string(call.turntable ? "--turntable" : "--camera-path") + ": more than " +
          std::to_string(most_frames) + " frames");
  std::vector<FrameNumber> numbers(std::size_t(std::max(count, 1.0)));
  std::iota(numbers.begin(), numbers.end(), FrameNumber(first));
  return numbers;
}

/// The file before a frame, else the first one.
const std::string& held(const SequenceFiles& files, FrameNumber frame) {
  const auto after = files.upper_bound(frame);
  return after == files.begin() ? after->second : std::prev(after)->second;
}

std::vector<std::string> samples_of(const std::string& auto_from, const SequenceFiles& files) {
  if (auto_from == "all") return names_in(files, &SequenceFiles::value_type::second);
  if (auto_from.empty()) return auto_samples(files);
  std::vector<std::string> paths;
  for (const FrameNumber frame : read_frames(auto_from, "--auto-from")) {
    if (!files.contains(frame))
      throw Error(ExitCode::input, "--auto-from: frame " + std::to_string(frame) + " has no file");
    paths.push_back(files.at(frame));
  }
  return paths;
}

void name_outputs(const RenderCall& call, FrameList& list) {
  if (call.output.empty()) return;
  const auto pattern = FramePattern::of_placeholder(call.output);
  if (!pattern && list.frames.size() > 1) {
    if (is_standard_output(call.output))
      usage(std::to_string(list.frames.size()) + " frames need files: -o FILE.####.png");
    const std::size_t dot = std::min(call.output.rfind('.'), call.output.size());
    usage((call.sequence.inputs.size() > 1 ? "several files are frames of a sequence: " : "") +
          std::to_string(list.frames.size()) + " frames need a place for their number: -o " +
          shell_word(call.output.substr(0, dot) + ".####" + call.output.substr(dot)));
  }
  for (Frame& frame : list.frames) {
    frame.output = pattern ? pattern->path(frame.number) : call.output;
    InputProtection::expect(frame_of_file(frame.input).file);
  }
}

/// Throws Error(input) unless a file beside the volume is there for each frame.
void check_beside(const std::string& option, const std::string& name, const FrameList& list) {
  const auto files = FramePattern::of_placeholder(name);
  if (!files) return;
  std::vector<FrameNumber> missing;
  for (const Frame& frame : list.frames) {
    const std::string file = LayerOfFile(files->path(frame.number)).file;
    if (!std::filesystem::exists(file)) missing.push_back(frame.number);
    InputProtection::expect(file);
  }
  if (!missing.empty())
    throw Error(ExitCode::input,
                option + " " + in_quotes(name) + " has no file for: " + frames_text(missing));
}

FrameNumber number_of(const std::string& file) {
  const std::optional<FrameNumber> number = frame_number("", file);
  if (!number)
    usage("-o has a place for the number of a frame, and " + in_quotes(file) + " has none");
  return *number;
}

}  // namespace

FrameList list_files(const FrameOptions& options, const SequenceFiles& files) {
  FrameList list;
  list.first = files.begin()->first;
  list.files = names_in(files, &SequenceFiles::value_type::second);
  list.samples = samples_of(options.auto_from, files);
  list.headers = options.auto_from.empty() ? Headers::seen : Headers::placed;
  std::vector<FrameNumber> there, numbers, missing;
  for (const auto& [frame, path] : files) there.push_back(frame);
  if (options.frames.empty()) {
    numbers = there;
    // files that were named one by one are those that are wanted
    if (options.inputs.size() == 1 || options.missing == "hold") missing = gaps(files);
    if (options.missing == "hold") numbers.insert(numbers.end(), missing.begin(), missing.end());
    std::ranges::sort(numbers);
  } else {
    numbers = read_frames(options.frames, "--frames");
    for (const FrameNumber frame : numbers)
      if (!files.contains(frame)) missing.push_back(frame);
  }
  for (const FrameNumber frame : numbers) {
    const auto file = files.find(frame);
    if (file != files.end())
      list.frames.push_back({frame, file->second, {}});
    else if (options.missing == "hold")
      list.frames.push_back({frame, held(files, frame), {}});
  }
  const auto drawn = [&](const std::string& path) {
    return std::ranges::find(list.frames, path, &Frame::input) != list.frames.end();
  };
  list.others_serve = options.auto_from.empty() && !std::ranges::all_of(list.samples, drawn);
  if (missing.empty()) return list;
  const std::string which = std::to_string(missing.size()) +
                            (missing.size() > 1 ? " frames have" : " frame has") +
                            " no file: " + frames_text(missing);
  if (options.missing == "error" && !options.frames.empty())
    throw Error(ExitCode::input, which + "; the files have frames " + frames_text(there) +
                                     "; --missing skip or hold goes on without");
  list.notices.push_back(which + (options.missing == "hold"
                                      ? "; the frame before is drawn, or the first one after"
                                      : ""));
  if (list.frames.empty()) throw Error(ExitCode::input, which);
  return list;
}

std::optional<FrameList> list_frames(const RenderCall& call, const Scene& scene,
                                     const CameraPath* path) {
  std::vector<std::string> inputs = call.sequence.inputs;
  if (inputs.empty() && !scene.input.empty()) inputs.push_back(scene.input);
  if (inputs.empty()) return {};
  const bool within = !call.sequence.frames.empty() && !call.turntable && !path;
  std::optional<SequenceFiles> files = sequence_files(inputs, within);
  if (!files && !call.turntable && !path && FramePattern::of_placeholder(call.output))
    files = {{number_of(inputs.front()), inputs.front()}};
  if (!files && !call.turntable && !path) {
    for (const auto& [given, option] : {std::pair{!call.sequence.frames.empty(), "--frames"},
                                        {call.follow, "--follow"},
                                        {!call.sequence.auto_from.empty(), "--auto-from"},
                                        {call.resume, "--resume"},
                                        {call.keep_going, "--keep-going"},
                                        {!call.movie.empty(), "--movie"}})
      if (given)
        usage(std::string(option) +
              " is for a sequence: give fire.####.vdb, a folder, "
              "a scan with --frames, several files, --turntable or --camera-path");
    return {};
  }
  FrameList list;
  if (files) {
    list = list_files(call.sequence, *files);
  } else {
    for (const FrameNumber number : numbers_of_file(call, path))
      list.frames.push_back({number, inputs.front(), {}});
    list.samples = {inputs.front()};
  }
  name_outputs(call, list);
  check_beside("--holdout", scene.holdout, list);
  for (const std::string& volume : scene.volumes)
    check_beside("--and", scene_of_volume(scene, volume).input, list);
  for (const Frame& frame : list.frames) check_outputs(call, frame.output);
  return list;
}

SequenceScene chosen_for(const FrameList& list, const Scene& scene, bool background,
                         bool others_serve) {
  try {
    return resolve_sequence(scene, list.samples, "auto", background, list.files, false,
                            list.headers);
  } catch (const Error& error) {
    if (error.code() != ExitCode::input || !others_serve) throw;
    return resolve_sequence(scene, list.samples, "auto", background, list.files, true,
                            list.headers);
  }
}

void print_choice(const SequenceScene& sequence, const FrameList& list, bool to_copy) {
  print_notices(list.notices);
  print_notices(sequence.notices);
  print_dark(sequence.scene, sequence.dark_because);
  print_notice(formatted("%zu frame%s; chosen from %zu file%s: ", list.frames.size(),
                         list.frames.size() == 1 ? "" : "s", list.samples.size(),
                         list.samples.size() == 1 ? "" : "s") +
               look_text(sequence.look, sequence.settings, to_copy));
}

}  // namespace psivox
