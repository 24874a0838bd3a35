#include "view/recent_files.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "psivox/error.h"
#include "psivox/text_file.h"

namespace psivox::view {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kept = 10;

/// By the XDG base directory specification; empty if there is no home.
fs::path list_file() {
  if (const char* state = std::getenv("XDG_STATE_HOME"); state && *state)
    return fs::path(state) / "psivox" / "recent";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".local/state/psivox/recent";
  return {};
}

}  // namespace

std::vector<std::string> recent_files() {
  std::vector<std::string> files;
  std::error_code missing;
  if (!fs::exists(list_file(), missing)) return files;
  try {
    std::istringstream lines(read_text(list_file().string(), "list of recent files"));
    for (std::string line; files.size() < kept && std::getline(lines, line);)
      if (!line.empty()) files.push_back(line);
  } catch (const Error&) {
  }
  return files;
}

void remember_file(const std::string& path) {
  const fs::path list = list_file();
  if (list.empty()) return;
  std::error_code failed;
  const std::string whole = fs::absolute(path, failed).string();
  std::vector<std::string> files = recent_files();
  std::erase(files, whole);
  files.insert(files.begin(), whole);
  std::string text;
  for (std::size_t i = 0; i < std::min(files.size(), kept); ++i) text += files[i] + "\n";
  fs::create_directories(list.parent_path(), failed);
  try {
    write_text(list.string(), text);
  } catch (const Error&) {
  }
}

}  // namespace psivox::view
