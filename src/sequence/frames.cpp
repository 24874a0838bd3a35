#include "psivox/sequence.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <numeric>
#include <regex>
#include <set>

#include "base/file_blocks.h"
#include "base/text.h"
#include "look/choices.h"
#include "psivox/error.h"

// Numbers of frames, and the files that have them.

namespace psivox {

bool has_volume_name(const std::string& path) {
  const std::string name = lower_case(path);
  return std::ranges::any_of(std::array{".vdb", ".nvdb", ".nii", ".nii.gz", ".nrrd", ".nhdr"},
                             [&](const char* extension) { return name.ends_with(extension); });
}

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_digits = 18;  // of a FrameNumber

const std::regex& placeholder() {
  static const std::regex pattern(R"((#+)|%(0(\d))?d|\$F(\d?))");
  return pattern;
}

/// Digits that a placeholder asks for, 1 at least.
std::size_t digits_of(const std::smatch& found) {
  if (found[1].matched) return std::size_t(found[1].length());
  const std::string digits = found[3].matched ? found[3].str() : found[4].str();
  return digits.empty() || digits == "0" ? 1 : std::size_t(digits[0] - '0');
}

[[noreturn]] void refuse_frames(const std::string& option, const std::string& text) {
  throw Error(
      ExitCode::usage,
      option + ": expected frames such as 1-100, 1-100x2 or 1-10,20, not " + in_quotes(text));
}

/// First, last and step of `7`, `1-100` or `1-100x2`.
struct Span {
  FrameNumber first = 0, last = 0, step = 1;
};

Span read_span(const std::string& item, const std::string& option, const std::string& text) {
  Span span;
  const std::size_t x = item.find('x');
  const std::string ends = item.substr(0, x);
  const std::size_t dash = ends.find('-', 1);  // a first one is a sign
  bool good = read_number(ends.substr(0, dash), span.first);
  span.last = span.first;
  if (dash != std::string::npos) good &= read_number(ends.substr(dash + 1), span.last);
  if (x != std::string::npos)
    good &= dash != std::string::npos && read_number(item.substr(x + 1), span.step);
  if (!good || span.last < span.first || span.step < 1) refuse_frames(option, text);
  return span;
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::string foreign = foreign_format(folder);
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    const std::string path = (fs::path(folder) / entry.path().filename()).string();
    if (entry.path().filename().string().starts_with('.')) continue;  // hidden
    if (has_volume_name(path) && !entry.is_directory(unreadable))
      paths.push_back(path);
    else if (foreign.empty() && !foreign_format(path).empty())
      foreign =
          "has no volume, but " + in_quotes(path) + "; see docs/interchange.md for such formats";
  }
  if (paths.empty())
    throw Error(ExitCode::input, foreign.empty() ? "folder " + in_quotes(folder) + " has no volume"
                                                 : folder + ": " + foreign);
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// The files by the last numbers of their names, if nothing else differs.
std::optional<SequenceFiles> numbered(std::span<const std::string> paths) {
  const std::optional<FramePattern> pattern = FramePattern::of_number(paths.front());
  if (!pattern) return {};
  SequenceFiles files;
  for (const std::string& path : paths) {
    const std::optional<FrameNumber> frame = pattern->frame_of(path);
    if (!frame || !files.emplace(*frame, path).second) return {};
  }
  return files;
}

/// The pattern of the first two files that belong to one sequence; empty if none do.
std::string first_sequence(std::span<const std::string> paths) {
  for (std::size_t i = 1; i < paths.size(); ++i)
    if (numbered(paths.subspan(i - 1, 2)))
      return FramePattern::of_number(paths[i])->text(
          std::min(paths[i - 1], paths[i],
                   [](const std::string& a, const std::string& b) { return a.size() < b.size(); }));
  return {};
}

/// The frames of a scan, from 0 on; unset if it has one, or cannot be read.
std::optional<SequenceFiles> frames_within(const std::string& path) {
  try {
    const VolumeFile file(path);
    if (!file.metadata().contains("frames")) return {};
    SequenceFiles files;
    for (const std::string& name : file.names())
      files.emplace(FrameNumber(files.size()), path + name.substr(name.rfind('[')));
    return files;
  } catch (const Error&) {  // opening it again will say why
    return {};
  }
}

/// The most files that are searched for a flame, and voxels of flames whose values are read.
constexpr std::size_t most_surveyed = 64, most_read = 1 << 26;

/// Voxels that burn; unset if the file has no grid of a flame, or cannot be read.
std::optional<std::uint64_t> burning_voxels(const std::string& path) {
  try {
    const VolumeFile file(path);
    if (const std::string flame = flame_grid(file); !flame.empty()) {
      const GridContent content = file.content(flame);
      return content.nothing.empty() ? content.active_voxels : 0;
    }
  } catch (const Error&) {  // drawing it will say why
  }
  return {};
}

/// The greatest value of a file's flame; 0 if it cannot be read.
double greatest_flame(const std::string& path) {
  try {
    return find_flame(VolumeFile(path), "").greatest;
  } catch (const Error&) {  // drawing it will say why
    return 0;
  }
}

/// Adds the file in which most voxels burn, and that of the hottest flame: a blast is over when its
/// flame is largest. Where there are many voxels, a part of the files is read.
void add_brightest(std::span<const std::string> paths,
                   const std::map<std::size_t, std::uint64_t>& burning,
                   std::set<std::size_t>& samples) {
  if (burning.empty()) return;
  std::uint64_t voxels = 0;
  for (const auto& [n, own] : burning) voxels += own;
  std::size_t number = 0, hottest = 0;
  double greatest = 0;
  for (const auto& [n, own] : burning) {
    if (number++ % (1 + voxels / most_read)) continue;
    const double here = greatest_flame(paths[n]);
    if (here > greatest) hottest = n;
    greatest = std::max(greatest, here);
  }
  if (greatest > 0) samples.insert(hottest);
  samples.insert(
      std::ranges::max_element(burning, {}, [](const auto& b) { return b.second; })->first);
}

}  // namespace

std::optional<FramePattern> FramePattern::of_placeholder(const std::string& path) {
  std::smatch found;
  if (!std::regex_search(path, found, placeholder())) return {};
  FramePattern pattern;
  pattern.before_ = found.prefix();
  pattern.after_ = found.suffix();
  pattern.digits_ = digits_of(found);
  if (std::regex_search(pattern.after_, placeholder()))
    throw Error(ExitCode::usage, in_quotes(path) + " has two places for a frame's number");
  if (pattern.after_.find('/') != std::string::npos)
    throw Error(ExitCode::usage,
                in_quotes(path) + ": the place for a frame's number must be in the file's name");
  if (pattern.digits_ > most_digits)
    throw Error(ExitCode::usage, in_quotes(path) + ": a frame's number has at most " +
                                     std::to_string(most_digits) + " digits");
  return pattern;
}

std::optional<FramePattern> FramePattern::of_number(const std::string& path) {
  const std::size_t name = path.find_last_of('/') + 1;  // npos + 1 is 0
  const std::string extension = fs::path(path).extension().string();
  const std::size_t end = path.size() - extension.size();
  const std::size_t last = path.find_last_of("0123456789", end ? end - 1 : 0);
  if (last == std::string::npos || last < name) return {};
  const std::size_t before = path.find_last_not_of("0123456789", last);
  std::size_t first = std::max(before == std::string::npos ? 0 : before + 1, name);
  // `fire.-012.vdb` is before frame 0, and `fire-012.vdb` is not
  if (first > name && path[first - 1] == '-' &&
      (first - 1 == name || path[first - 2] == '.' || path[first - 2] == '_'))
    --first;
  FramePattern pattern;
  pattern.before_ = path.substr(0, first);
  pattern.after_ = path.substr(last + 1);
  return pattern;
}

std::string FramePattern::text(const std::string& path) const {
  return before_ + std::string(path.size() - before_.size() - after_.size(), '#') + after_;
}

std::string FramePattern::path(FrameNumber frame) const {
  return before_ +
         formatted("%0*lld", int(std::max<std::size_t>(digits_, 1)),
                   static_cast<long long>(frame)) +
         after_;
}

std::optional<FrameNumber> FramePattern::frame_of(const std::string& path) const {
  if (!path.starts_with(before_) || !path.ends_with(after_) ||
      path.size() <= before_.size() + after_.size())
    return {};
  const std::string number =
      path.substr(before_.size(), path.size() - before_.size() - after_.size());
  FrameNumber frame = 0;
  if (number.size() > most_digits || !read_number(number, frame)) return {};
  const bool padded = digits_ > 0;
  if (padded && number.size() < digits_) return {};
  if (padded && number.size() > digits_ && number[0] == '0') return {};
  return frame;
}

FramePattern FramePattern::in_any_padding() const {
  FramePattern any = *this;
  any.digits_ = 0;
  return any;
}

SequenceFiles FramePattern::files() const {
  SequenceFiles found;
  const fs::path folder = fs::path(before_).parent_path();
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, unreadable)) {
    const std::string path =
        before_.substr(0, before_.find_last_of('/') + 1) + entry.path().filename().string();
    if (const std::optional<FrameNumber> frame = frame_of(path)) found.emplace(*frame, path);
  }
  return found;
}

std::optional<FrameNumber> frame_number(const std::string& pattern, const std::string& path) {
  std::optional<FramePattern> names = FramePattern::of_placeholder(pattern);
  if (!names) names = FramePattern::of_number(path);
  return names ? names->frame_of(path) : std::nullopt;
}

std::vector<FrameNumber> read_frames(const std::string& text, const std::string& option) {
  std::set<FrameNumber> frames;
  for (const std::string& item : split(text)) {
    const Span span = read_span(item, option, text);
    for (FrameNumber frame = span.first; frame <= span.last; frame += span.step) {
      frames.insert(frame);
      if (int(frames.size()) > most_frames)
        throw Error(ExitCode::usage, option + " " + in_quotes(text) + ": more than " +
                                         std::to_string(most_frames) + " frames");
    }
  }
  if (frames.empty()) refuse_frames(option, text);
  return {frames.begin(), frames.end()};
}

std::string frames_text(std::span<const FrameNumber> frames) {
  std::vector<std::string> items;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i + 1;
    const FrameNumber step = end < frames.size() ? frames[end] - frames[i] : 0;
    while (end < frames.size() && frames[end] - frames[end - 1] == step) ++end;
    if (end - i == 2 && step > 1) end = i + 1;  // two numbers are no series
    std::string item = std::to_string(frames[i]);
    if (end - i > 1) item += "-" + std::to_string(frames[end - 1]);
    if (end - i > 1 && step > 1) item += "x" + std::to_string(step);
    items.push_back(item);
    i = end;
  }
  return joined(items);
}

std::vector<FrameNumber> gaps(const SequenceFiles& files) {
  FrameNumber step = std::numeric_limits<FrameNumber>::max(), common = 0;
  for (auto file = files.begin(), next = file; file != files.end(); file = next) {
    if (++next == files.end()) break;
    step = std::min(step, next->first - file->first);
    common = std::gcd(common, next->first - file->first);
  }
  std::vector<FrameNumber> missing;
  if (common != step) return missing;  // the numbers follow no step
  const FrameNumber first = files.begin()->first, last = files.rbegin()->first;
  constexpr FrameNumber most_counted = 999999999;  // beyond, numbers are times
  if (last > most_counted || (last - first) / step > most_frames) return missing;
  for (FrameNumber frame = first; frame < last; frame += step)
    if (!files.contains(frame)) missing.push_back(frame);
  return missing;
}

std::optional<SequenceFiles> sequence_files(std::span<const std::string> inputs, bool within) {
  std::vector<std::string> paths(inputs.begin(), inputs.end());
  if (inputs.size() == 1) {
    const std::string& input = inputs.front();
    std::error_code unknown;
    if (fs::is_directory(input, unknown)) {
      paths = files_in(input);
    } else {
      if (fs::exists(input, unknown))
        return within ? frames_within(input) : std::optional<SequenceFiles>{};
      const std::optional<FramePattern> pattern = FramePattern::of_placeholder(input);
      if (!pattern) return {};
      SequenceFiles files = pattern->files();
      if (files.empty()) {
        const SequenceFiles others = pattern->in_any_padding().files();
        throw Error(ExitCode::input,
                    "no file matches " + in_quotes(input) +
                        (others.empty() ? "" : "; there is " + in_quotes(others.begin()->second)));
      }
      return files;
    }
  }
  if (std::optional<SequenceFiles> files = numbered(paths)) return files;
  if (inputs.size() == 1)
    if (const std::string first = first_sequence(paths); !first.empty())
      throw Error(ExitCode::usage, "folder " + in_quotes(inputs.front()) +
                                       " holds more than one sequence; give one, such as " +
                                       in_quotes(first));
  SequenceFiles files;
  for (const std::string& path : paths) files.emplace(FrameNumber(files.size()) + 1, path);
  return files;
}

std::vector<std::string> auto_samples(const SequenceFiles& files) {
  std::vector<std::string> paths = names_in(files, &SequenceFiles::value_type::second);
  std::set<std::size_t> samples{0, paths.size() / 2, paths.size() - 1};
  const bool may_burn = std::ranges::any_of(
      samples, [&](std::size_t n) { return burning_voxels(paths[n]).has_value(); });
  if (may_burn && paths.size() > samples.size()) {
    std::map<std::size_t, std::uint64_t> burning;  // voxels of files
    const std::size_t count = std::min(paths.size(), most_surveyed);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t n = i * (paths.size() - 1) / (count - 1);
      if (const std::uint64_t voxels = burning_voxels(paths[n]).value_or(0)) burning[n] = voxels;
    }
    add_brightest(paths, burning, samples);
  }
  std::vector<std::string> chosen;
  for (const std::size_t n : samples) chosen.push_back(paths[n]);
  return chosen;
}

}  // namespace psivox
