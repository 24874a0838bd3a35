#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>

#include "base/foreign_format.h"
#include "base/text.h"
#include "look/flame.h"
#include "psivox/error.h"
#include "psivox/sequence.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// Whether psivox reads files of that name.
bool has_format(const std::string& path) {
  const std::string name = lower_case(path);
  return std::ranges::any_of(std::array{".vdb", ".nvdb", ".nii", ".nii.gz", ".nrrd", ".nhdr"},
                             [&](const char* extension) { return name.ends_with(extension); });
}

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::string foreign = foreign_format(folder);
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    const std::string path = (fs::path(folder) / entry.path().filename()).string();
    if (has_format(path) && !entry.is_directory(unreadable))
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
    const std::optional<int> frame = pattern->frame_of(path);
    if (!frame || !files.emplace(*frame, path).second) return {};
  }
  return files;
}

/// Whether two of the files belong to one sequence.
bool has_sequence(std::span<const std::string> paths) {
  for (std::size_t i = 1; i < paths.size(); ++i)
    if (numbered(paths.subspan(i - 1, 2))) return true;
  return false;
}

/// The frames of a scan, from 0 on; unset if it has one, or cannot be read.
std::optional<SequenceFiles> frames_within(const std::string& path) {
  try {
    const VdbFile file(path);
    if (!file.metadata().contains("frames")) return {};
    SequenceFiles files;
    for (const std::string& name : file.names())
      files.emplace(int(files.size()), path + name.substr(name.rfind('[')));
    return files;
  } catch (const Error&) {  // opening it again will say why
    return {};
  }
}

/// Files that are looked at for a flame.
constexpr std::size_t most_surveyed = 64;

/// Voxels that burn; unset if the file has no grid of a flame, or cannot be read.
std::optional<std::uint64_t> burning_voxels(const std::string& path) {
  try {
    const VdbFile file(path);
    for (const char* name : flame_names(/*hot=*/false)) {
      if (file.channels(name) != 1) continue;
      const GridContent content = file.content(name);
      return content.nothing.empty() ? content.active_voxels : 0;
    }
  } catch (const Error&) {  // drawing it will say why
  }
  return {};
}

}  // namespace

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
      if (files.empty()) throw Error(ExitCode::input, "no file matches " + in_quotes(input));
      return files;
    }
  }
  if (std::optional<SequenceFiles> files = numbered(paths)) return files;
  if (inputs.size() == 1 && has_sequence(paths))
    throw Error(ExitCode::usage, "folder " + in_quotes(inputs.front()) +
                                     " holds more than one sequence; give one, such as " +
                                     in_quotes(inputs.front() + "/NAME.####.vdb"));
  SequenceFiles files;
  for (const std::string& path : paths) files.emplace(int(files.size()) + 1, path);
  return files;
}

std::vector<std::string> auto_samples(const SequenceFiles& files) {
  std::vector<std::string> paths;
  for (const auto& [frame, path] : files) paths.push_back(path);
  std::set<std::size_t> samples{0, paths.size() / 2, paths.size() - 1};
  const bool may_burn = std::ranges::any_of(
      samples, [&](std::size_t n) { return burning_voxels(paths[n]).has_value(); });
  if (may_burn && paths.size() > samples.size()) {
    std::size_t most = 0;
    std::uint64_t voxels = 0;
    const std::size_t count = std::min(paths.size(), most_surveyed);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t n = count == 1 ? 0 : i * (paths.size() - 1) / (count - 1);
      if (const std::uint64_t burning = burning_voxels(paths[n]).value_or(0); burning > voxels) {
        voxels = burning;
        most = n;
      }
    }
    if (voxels > 0) samples.insert(most);
  }
  std::vector<std::string> chosen;
  for (const std::size_t n : samples) chosen.push_back(paths[n]);
  return chosen;
}

}  // namespace psivox
