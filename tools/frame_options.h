#pragma once

#include <string>
#include <vector>

#include "command_line.h"

namespace psivox {

/// The options that say which frames a command works on.
struct FrameOptions {
  std::vector<std::string> inputs;
  std::string frames;             ///< empty: all
  std::string auto_from;          ///< empty: the first, the middle and the last; `all`
  std::string missing = "error";  ///< or `skip`, `hold`

  void add_to(CommandLine& line);
};

/// Their section in --help.
inline constexpr const char* frames_group = "Frames";

}  // namespace psivox
