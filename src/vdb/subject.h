#pragma once

#include <string>
#include <string_view>

namespace psivox::vdb {

/// How a message about a file begins, and about one of its grids unless that is "".
inline std::string subject(const std::string& path, std::string_view grid = {}) {
  return path + ": " + (grid.empty() ? "" : "grid '" + std::string(grid) + "' ");
}

/// A message where its subject is known.
inline std::string without_subject(const std::string& message, const std::string& path,
                                   std::string_view grid) {
  for (const std::string& start : {subject(path, grid), subject(path)})
    if (message.starts_with(start)) return message.substr(start.size());
  return message;
}

}  // namespace psivox::vdb
