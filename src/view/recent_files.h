#pragma once

#include <string>
#include <vector>

namespace psivox::view {

/// The files that the user opened last, the newest first.
std::vector<std::string> recent_files();

/// Puts a file first. Ignores it if the list cannot be written.
void remember_file(const std::string& path);

}  // namespace psivox::view
