#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace psivox {

/// Exit codes of the program; an Error carries one.
enum class ExitCode : int {
  ok = 0,
  failure = 1,        ///< anything not named below
  usage = 2,          ///< unknown or malformed option
  input = 3,          ///< missing, corrupt or unsupported grid or file
  graphics = 4,       ///< no EGL device, shader, device limit, lost context
  output = 5,         ///< the result cannot be written
  memory = 6,         ///< over --memory-limit
  verification = 7,   ///< a comparison or a check failed
  interrupted = 130,  ///< Ctrl-C, as shells report it
};

/// The only exception type. Its message is one line: what failed, in which file or grid, and what
/// to do. It is thrown where the name is known and caught once in main.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// Long work calls it with the finished fraction, 0 to 1, from one thread. It may be empty.
using Progress = std::function<void(double fraction)>;

}  // namespace psivox
