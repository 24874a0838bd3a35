#pragma once

#include <string>
#include <vector>

namespace psivox::view {

/// Files that were opened last, the newest first, as the user's configuration keeps them.
std::vector<std::string> recent_files();

/// Puts a file first. What cannot be written is forgotten.
void remember_file(const std::string& path);

}  // namespace psivox::view
