#include <algorithm>
#include <filesystem>

#include "psivox/error.h"
#include "psivox/foreign_format.h"
#include "psivox/sequence.h"
#include "psivox/text.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable))
    if (entry.path().extension() == ".vdb" && !entry.is_directory(unreadable))
      paths.push_back((fs::path(folder) / entry.path().filename()).string());
  if (const std::string format = foreign_format(folder); paths.empty() && !format.empty())
    throw Error(ExitCode::input, folder + ": " + format);
  if (paths.empty())
    throw Error(ExitCode::input, "folder " + in_quotes(folder) + " has no .vdb file");
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

}  // namespace

std::optional<SequenceFiles> sequence_files(std::span<const std::string> inputs) {
  std::vector<std::string> paths(inputs.begin(), inputs.end());
  if (inputs.size() == 1) {
    const std::string& input = inputs.front();
    std::error_code unknown;
    if (fs::is_directory(input, unknown)) {
      paths = files_in(input);
    } else {
      if (fs::exists(input, unknown)) return {};
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

}  // namespace psivox
