#pragma once

#include <span>
#include <string>

#include "psivox/error.h"

namespace psivox {

/// `arguments` follow the command's name. Commands throw Error; psivox.cpp turns it into a message
/// and an exit code.
using Arguments = std::span<const std::string>;

[[noreturn]] inline void usage(const std::string& message) {
  throw Error(ExitCode::usage, message);
}

void render_command(Arguments arguments);
void info_command(Arguments arguments);
void compare_command(Arguments arguments);
void study_command(Arguments arguments);
void verify_command(Arguments arguments);
void view_command(Arguments arguments);

/// The process ends with exit code 1, this message and no unfinished files, if it still runs then.
void end_after(int seconds, const char* message);

}  // namespace psivox
