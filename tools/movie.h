#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "base/text_file.h"
#include "psivox/image.h"

namespace psivox {

/// A film that ffmpeg writes from pictures. It appears under its name when it is complete.
class Movie {
 public:
  /// Throws Error(usage) for a name that ffmpeg does not know, Error(output) if no file
  /// can be made there.
  Movie(const std::string& path, double frame_rate);
  ~Movie();
  Movie(const Movie&) = delete;
  Movie& operator=(const Movie&) = delete;

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

/// Whether a file of this name is a film.
bool is_movie_name(const std::string& path);

/// Throws Error(usage) for a name of a film that ffmpeg does not know.
void check_movie_name(const std::string& path);

/// Whether there is an ffmpeg.
bool can_make_movies();

}  // namespace psivox
