#include "movie.h"

#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "app/command_text.h"
#include "base/text.h"
#include "psivox/error.h"
#include "psivox/sequence.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// ffmpeg's name of the format; null: it is no film's.
const char* format_of(const std::string& path) {
  constexpr std::pair<const char*, const char*> formats[] = {
      {".mp4", "mp4"}, {".mov", "mov"}, {".mkv", "matroska"}, {".avi", "avi"}};
  for (const auto& [extension, format] : formats)
    if (path.ends_with(extension)) return format;
  return nullptr;
}

/// What every player shows: H.264, colours at half resolution, an even width and height.
const std::string encoding =
    "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264 -crf 17 -pix_fmt yuv420p";

}  // namespace

bool is_movie_name(const std::string& path) { return format_of(path); }

bool can_make_movies() {
  const char* folders = std::getenv("PATH");
  for (const std::string& folder : split(folders ? folders : "", ':'))
    if (::access((fs::path(folder) / "ffmpeg").c_str(), X_OK) == 0) return true;
  return false;
}

std::string movie_command(const std::string& pictures, const std::string& movie,
                          double frame_rate) {
  std::string names = pictures;
  if (const auto pattern = FramePattern::of_placeholder(pictures)) names = pattern->printf_form();
  return "ffmpeg -framerate " + number_text(frame_rate) + " -i " + names + " " + encoding + " " +
         movie;
}

Movie::Movie(const std::string& path, double frame_rate) : path_(path), frame_rate_(frame_rate) {
  try {
    file_.emplace(path);
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

Movie::~Movie() {
  if (ffmpeg_) ::pclose(ffmpeg_);
}

void Movie::fail(const std::string& why) {
  throw Error(ExitCode::output, "cannot write " + in_quotes(path_) + ": " + why);
}

void Movie::start(int width, int height) {
  const std::string command =
      "exec ffmpeg -loglevel error -xerror -y -f rawvideo -pixel_format rgb24 -video_size " +
      std::to_string(width) + "x" + std::to_string(height) + " -framerate " +
      number_text(frame_rate_) + " -i - " + encoding + " -f " + format_of(path_) + " " +
      shell_word(file_->path().string());
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early makes a write fail instead
  std::signal(SIGCHLD, SIG_DFL);  // if a parent ignored it, pclose() would not find ffmpeg's code
  ffmpeg_ = ::popen(command.c_str(), "we");
  if (!ffmpeg_) fail(std::string("ffmpeg: ") + std::strerror(errno));
}

void Movie::add(const Image& image, const Display& display) {
  if (!ffmpeg_) start(image.width, image.height);
  const std::vector<std::uint8_t> bytes = srgb_bytes(image, display);
  if (std::fwrite(bytes.data(), 1, bytes.size(), ffmpeg_) != bytes.size() ||
      std::fflush(ffmpeg_) != 0)
    fail("ffmpeg ended early");
}

void Movie::finish() {
  if (!ffmpeg_) return;
  if (::pclose(std::exchange(ffmpeg_, nullptr)) != 0) fail("ffmpeg failed");
  try {
    file_->show();
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

}  // namespace psivox
