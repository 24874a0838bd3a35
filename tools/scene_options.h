#pragma once

#include <span>
#include <string>
#include <vector>

#include "command_line.h"
#include "psivox/scene.h"

namespace psivox {

/// The scene as a command line gives it: a file's, and over it the options.
class SceneOptions {
 public:
  /// All options but those of the parameters named.
  void add_to(CommandLine& line, std::span<const std::string> without = {});

  /// Validated, not yet resolved. Throws Error(usage), Error(input).
  /// `base` is what a file does not replace.
  Scene scene(Scene base = {}) const;

 private:
  std::string file_;
  std::vector<Setting> settings_;
};

}  // namespace psivox
