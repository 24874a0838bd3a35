#include "view/file_watch.h"

#include <filesystem>

namespace psivox::view {
namespace {

namespace fs = std::filesystem;

constexpr auto watch_interval = std::chrono::milliseconds(500);

/// Time and size of the file; empty if there is none.
std::string file_stamp(const std::string& path) {
  std::error_code missing;
  const auto time = fs::last_write_time(path, missing);
  if (missing) return "";
  const auto size = fs::file_size(path, missing);
  return std::to_string(time.time_since_epoch().count()) + "/" + std::to_string(size);
}

}  // namespace

bool FileWatch::changed(const std::string& path) {
  const auto now = std::chrono::steady_clock::now();
  if (now - looked_at_ < watch_interval) return false;
  looked_at_ = now;
  const std::string stamp = file_stamp(path);
  const bool changed = path_ == path && !stamp.empty() && stamp != stamp_;
  path_ = path;
  stamp_ = stamp;
  return changed;
}

}  // namespace psivox::view
