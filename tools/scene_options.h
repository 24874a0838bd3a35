#pragma once

#include "command_line.h"
#include "psivox/scene.h"

namespace psivox {

/// The scene of a command line: the scene of a file, with the camera of another, overridden by
/// options.
class SceneOptions {
 public:
  /// Adds all options but the parameters in `without`.
  void add_to(CommandLine& line, const std::vector<std::string>& without);

  /// Sets a parameter as the command line would.
  void set(const std::string& name, const std::string& text) { settings_.push_back({name, text}); }

  /// What to say about the colours that the command line gives.
  std::vector<std::string> notices() const;

  /// Returns the scene, validated but not resolved. `base` supplies what the file does not set.
  /// Throws Error(usage), Error(input).
  Scene scene(Scene base = {});

  /// The layers that the picture of --scene was drawn with, once scene() was called.
  const std::vector<std::string>& layers() const { return layers_; }

 private:
  std::string file_, camera_;
  std::vector<Setting> settings_;
  std::vector<std::string> layers_;
};

/// Whether Z is up, by the scene or else by its input, the first file of a sequence.
bool file_z_is_up(const Scene& scene);

/// The options that say which frames a command works on.
struct FrameOptions {
  std::vector<std::string> inputs;
  std::string frames;             ///< empty: all
  std::string auto_from;          ///< empty: the first, the middle and the last; `all`
  std::string missing = "error";  ///< or `skip`, `hold`

  /// Begins their section of --help.
  void add_to(CommandLine& line);
};

}  // namespace psivox
