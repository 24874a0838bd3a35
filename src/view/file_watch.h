#pragma once

#include <chrono>
#include <string>

namespace psivox::view {

/// Notices that a file was written again. It looks at most twice a second.
class FileWatch {
 public:
  /// Whether the file differs from what it was at the last look; false at the first look at a path,
  /// and while there is no such file.
  bool changed(const std::string& path);

 private:
  std::string path_, stamp_;
  std::chrono::steady_clock::time_point looked_at_{};
};

}  // namespace psivox::view
