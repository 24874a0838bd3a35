#pragma once

#include <string>
#include <string_view>

namespace psivox {

/// Text of a file for a terminal: control characters are escaped as \x1b.
std::string printable(std::string_view text);

}  // namespace psivox
