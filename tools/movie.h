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
