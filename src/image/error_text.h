#pragma once

#include <filesystem>
#include <string>

#include "psivox/error.h"

namespace psivox::image_io {

/// `text` without line breaks: libraries report several lines, an Error has one.
std::string one_line(const std::string& text);

/// "cannot read 'path': why", Error(input).
Error read_error(const std::filesystem::path& path, const std::string& why);

/// "cannot write 'path': why", Error(output).
Error write_error(const std::filesystem::path& path, const std::string& why);

}  // namespace psivox::image_io
