#pragma once

#include <string>

namespace psivox {

/// The whole file. Throws Error(input): "cannot read `what` 'path': why".
std::string read_text(const std::string& path, const std::string& what);

/// Writes `text` beside the file's name and renames it; to anything but a regular file (a pipe,
/// /dev/stdout) directly; `-` is the standard output. Throws Error(output).
void write_text(const std::string& path, const std::string& text);

/// Throws Error(output) where write_text could not begin.
void check_text_writable(const std::string& path);

}  // namespace psivox
