#pragma once

#include <string>
#include <vector>

#include "command_line.h"
#include "psivox/scene.h"

namespace psivox {

/// The scene as a command line gives it: a file's, and over it the options.
class SceneOptions {
 public:
  void add_to(CommandLine& line);

  /// Validated, not yet resolved. Throws Error(usage), Error(input).
  Scene scene() const;

 private:
  std::string file_;
  std::vector<Setting> settings_;
};

}  // namespace psivox
