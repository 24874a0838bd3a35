#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "base/text_file.h"
#include "psivox/draw.h"
#include "psivox/medium.h"
#include "render_call.h"

namespace psivox {

/// Time since the process started, which includes loading its libraries [ms].
double process_ms();

/// What one `psivox render` did, for --stats and -v.
struct RenderReport {
  std::string input, output;
  Drawn drawn;
  double startup_ms = 0;  ///< until the command began: loading of libraries
  double read_ms = 0, write_ms = 0, total_ms = 0;
  std::optional<CheckedError> checked;  ///< from --check-error
  std::uint64_t output_bytes = 0;
  std::uint64_t clipped = 0;  ///< pixels brighter than the output's white

  std::string json() const;
  std::string table() const;  ///< lines to be read by people
};

/// Whether a look's background is wanted: not where a picture may be composited as it is, nor where
/// --background is given, if only as `none`.
bool shows_background(const RenderCall& call);

/// Writes the report's picture with its scene, composited with the background and with the color
/// bar that the scene asks for, and completes the report. Returns sentences for the user. Throws
/// Error(output).
std::vector<std::string> write_picture(const RenderCall& call, const std::string& output,
                                       const View& view, RenderReport& report);

/// Writes the picture of `psivox render` as write_picture does, or its page, and prints what there
/// is to say.
void put_out(const RenderCall& call, Session& session, RenderReport& report);

/// A film that ffmpeg writes from pictures. It appears under its name when it is complete.
class Movie {
 public:
  /// `path` must be a film's name. Throws Error(output) if no file can be made there.
  Movie(const std::string& path, double frame_rate);
  ~Movie();

  /// Appends a picture, over black. All have one size. Throws Error(output).
  void add(const Image& image, const Display& display);
  /// Ends the film. Throws Error(output).
  void finish();

 private:
  void start(int width, int height);
  [[noreturn]] void fail(const std::string& why);

  std::string path_;
  double frame_rate_;
  std::optional<HiddenFile> file_;
  std::FILE* ffmpeg_ = nullptr;
};

/// The command that makes a film of pictures `out.####.png`.
std::string movie_command(const std::string& pictures, const std::string& movie, double frame_rate);

/// Whether a file of this name is a film that ffmpeg writes.
bool is_movie_name(const std::string& path);

bool can_make_movies();

}  // namespace psivox
