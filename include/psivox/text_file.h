#pragma once

#include <string>

namespace psivox {

/// Reads the whole file. Throws Error(input): "cannot read WHAT 'PATH': why".
std::string read_text(const std::string& path, const std::string& what);

/// Writes `text` to a file beside `path` and renames it. Writes directly to anything that is not a
/// regular file (a pipe, /dev/stdout). `-` is the standard output. Throws Error(output).
void write_text(const std::string& path, const std::string& text);

/// Throws Error(output) if write_text could not begin.
void check_text_writable(const std::string& path);

}  // namespace psivox
