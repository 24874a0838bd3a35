#pragma once

#include <string>
#include <string_view>

namespace psivox {

/// What a file or folder that is no .vdb holds, and a line of Python or a command that makes psivox
/// draw it, as a sentence without its subject; empty if the format is not known. `head`: the file's
/// first bytes, which count before its name does.
std::string foreign_format(const std::string& path, std::string_view head = {});

}  // namespace psivox
