#include "movie.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "psivox/sequence.h"
#include "psivox/text.h"

extern char** environ;

namespace psivox {
namespace {

namespace fs = std::filesystem;

/// Extension, and ffmpeg's name of the format.
constexpr std::array<std::pair<const char*, const char*>, 4> formats{
    {{".mp4", "mp4"}, {".mov", "mov"}, {".mkv", "matroska"}, {".avi", "avi"}}};

/// Null: none.
const char* known_format(const std::string& path) {
  for (const auto& [extension, format] : formats)
    if (path.ends_with(extension)) return format;
  return nullptr;
}

const char* format_of(const std::string& path) {
  if (const char* format = known_format(path)) return format;
  throw Error(ExitCode::usage,
              "--movie " + in_quotes(path) + ": expected .mp4, .mov, .mkv or .avi");
}

/// What every player shows: H.264, colours at half resolution, an even width and height.
const std::vector<std::string>& encoding() {
  static const std::vector<std::string> options{
      "-vf",    "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "17", "-pix_fmt",
      "yuv420p"};
  return options;
}

}  // namespace

bool is_movie_name(const std::string& path) { return known_format(path); }

void check_movie_name(const std::string& path) { format_of(path); }

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
  return "ffmpeg -framerate " + number_text(frame_rate) + " -i " + names + " " +
         joined(encoding(), " ") + " " + movie;
}

Movie::Movie(const std::string& path, double frame_rate) : path_(path), frame_rate_(frame_rate) {
  format_of(path);
  try {
    file_.emplace(path);
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

Movie::~Movie() {
  if (pipe_ >= 0) ::close(pipe_);
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
}

void Movie::fail(const std::string& why) {
  throw Error(ExitCode::output, "cannot write " + in_quotes(path_) + ": " + why);
}

void Movie::start(int width, int height) {
  std::vector<std::string> words{"ffmpeg",
                                 "-loglevel",
                                 "error",
                                 "-xerror",
                                 "-y",
                                 "-f",
                                 "rawvideo",
                                 "-pixel_format",
                                 "rgb24",
                                 "-video_size",
                                 std::to_string(width) + "x" + std::to_string(height),
                                 "-framerate",
                                 number_text(frame_rate_),
                                 "-i",
                                 "-"};
  words.insert(words.end(), encoding().begin(), encoding().end());
  for (const std::string& word :
       {std::string("-f"), std::string(format_of(path_)), file_->path().string()})
    words.push_back(word);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);

  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail(std::strerror(errno));
  pipe_ = ends[1];
  std::signal(SIGPIPE, SIG_IGN);  // an ffmpeg that ends early makes write() fail instead
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const int failure =
      ::posix_spawnp(&process_, "ffmpeg", &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(ends[0]);
  if (failure == 0) return;
  process_ = -1;
  fail(std::string("ffmpeg: ") + std::strerror(failure));
}

void Movie::add(const Image& image, const Display& display) {
  if (process_ < 0) start(image.width, image.height);
  const std::vector<std::uint8_t> bytes = srgb_bytes(image, display);
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::write(pipe_, bytes.data() + at, bytes.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("ffmpeg ended early");
    at += std::size_t(count);
  }
}

void Movie::finish() {
  if (process_ < 0) return;
  ::close(std::exchange(pipe_, -1));
  int status = 0;
  ::waitpid(std::exchange(process_, -1), &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail("ffmpeg failed");
  try {
    file_->show();
  } catch (const std::system_error& failure) {
    fail(failure.code().message());
  }
}

}  // namespace psivox
