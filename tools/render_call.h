#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "command_line.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "psivox/page.h"

namespace psivox {

/// What the command line of `psivox render` asks for.
struct RenderCall {
  SceneOptions scene;
  FrameOptions sequence;
  std::string output, stats, camera;
  std::vector<std::string> layers;    ///< named by --aov
  std::optional<int> check_error;     ///< pixels
  std::optional<double> time_budget;  ///< [ms]
  std::optional<int> thumbnail;       ///< side [pixels]
  std::string thumbnail_name;         ///< may lack an extension, which `output` then has
  WriteOptions format;
  PageOptions page;  ///< where the output is one
  bool print_scene = false, explain = false, verbose = false, quiet = false, list_devices = false;

  // of a sequence
  std::string camera_path, movie;
  std::optional<int> turntable;  ///< pictures of a whole turn
  double frame_rate = 24;        ///< [frames/s]
  bool follow = false, resume = false, keep_going = false;
};

/// Returns false if it printed the help that was asked for. Throws Error(usage).
bool parse(RenderCall& call, Arguments arguments);

/// Without --aov, takes the layers of --scene's picture that the output can have.
void take_layers(RenderCall& call, const Scene& scene);

/// Makes every check that needs no work. Throws Error(usage), Error(memory), Error(output).
void check(const RenderCall& call, const Scene& scene);

/// The picture that the call asks for, without progress.
Wish wish_of(const RenderCall& call);

/// A file that an option writes. An empty path is none.
struct WrittenFile {
  const char* option;
  std::string path;
};

/// Throws Error(usage) if one of the files is also read, by whatever name or link, or written by
/// two options. Empty names and `-` are no files.
void check_overwriting(std::span<const WrittenFile> written, std::span<const std::string> read);

}  // namespace psivox
