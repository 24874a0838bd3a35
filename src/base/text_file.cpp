#include "base/text_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <mutex>
#include <set>
#include <system_error>

#include "base/input_file.h"
#include "base/memory.h"
#include "base/text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, int error) {
  throw Error(ExitCode::output, "cannot write " + in_quotes(path) + ": " + std::strerror(error));
}

fs::path directory_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// Writes to a file, null if it could not be opened, and closes it.
void write_whole(const std::string& path, std::FILE* file, const std::string& text) {
  if (!file) fail(path, errno);
  const bool complete = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  int error = complete ? 0 : errno;
  if (std::fclose(file) != 0 && !error) error = errno;
  if (error) fail(path, error);
}

/// Reads up to the end, and closes the file. Returns false, and sets errno, if the system cannot.
bool read_whole(int file, std::string& text) {
  constexpr std::size_t longest = 1 << 30;  // a device may have no end
  std::vector<char> bytes(1 << 16);
  ssize_t count;
  while ((count = ::read(file, bytes.data(), bytes.size())) > 0 || (count < 0 && errno == EINTR)) {
    if (count > 0) text.append(bytes.data(), std::size_t(count));
    if (text.size() > longest) break;
  }
  const int failure = count > 0 ? EFBIG : errno;
  ::close(file);
  errno = failure;
  return count == 0;
}

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

/// Whether somebody else has put a link or a pipe there, in a folder where everybody may put some:
/// Linux's rule for links that it follows itself.
bool is_strangers(const fs::path& path) {
  struct stat folder {
  }, own{};
  if (::stat(directory_of(path).c_str(), &folder) != 0 || ::lstat(path.c_str(), &own) != 0)
    return false;
  return (folder.st_mode & S_ISVTX) && (folder.st_mode & S_IWOTH) && own.st_uid != ::geteuid() &&
         own.st_uid != folder.st_uid;
}

/// The file that symbolic links lead to, whether it exists or not. Throws std::system_error for the
/// link of a stranger.
fs::path followed(fs::path path) {
  std::error_code ignored;
  for (int links = 0; links < 40 && fs::is_symlink(path, ignored); ++links) {
    if (is_strangers(path)) fail(EACCES);
    path = directory_of(path) / fs::read_symlink(path, ignored);
  }
  if (fs::is_symlink(path, ignored)) fail(ELOOP);
  return path;
}

bool is_special(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

}  // namespace

std::string read_text(const std::string& path, const std::string& what) {
  std::string why, text;
  const int file = path == "-" ? ::dup(STDIN_FILENO) : open_input(path, why);
  struct stat facts {};
  if (::fstat(file, &facts) == 0) claim_memory(double(facts.st_size), what + " " + in_quotes(path));
  if (file < 0 || !read_whole(file, text)) {
    if (why.empty()) why = std::strerror(errno);
    throw Error(ExitCode::input, "cannot read " + what + " " + in_quotes(path) + ": " + why);
  }
  return text;
}

void check_text_writable(const std::string& path) {
  if (path == "-") return;
  std::error_code unknown;
  if (fs::is_directory(path, unknown)) fail(path, EISDIR);
  if (unknown && unknown != std::errc::no_such_file_or_directory) fail(path, unknown.value());
  const std::string place = is_special(path) ? path : directory_of(path).string();
  if (access(place.c_str(), W_OK) != 0) fail(path, errno);
}

void write_text(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::cout << text;  // main checks whether it was written
    return;
  }
  if (is_special(path)) {
    if (is_strangers(path)) fail(path, EACCES);
    return write_whole(path, std::fopen(path.c_str(), "wb"), text);
  }
  try {
    HiddenFile file(path);
    write_whole(path, fdopen(file.open(), "wb"), text);
    file.show();
  } catch (const std::system_error& failure) {
    fail(path, failure.code().value());
  }
}

namespace {

constexpr const char* prefix = ".psivox-";
constexpr const char* suffix = ".tmp";

/// Whether HiddenFile gives such names: with two numbers.
bool is_hidden_name(std::string_view name) {
  if (!name.starts_with(prefix) || !name.ends_with(suffix)) return false;
  const std::string_view begin = prefix, end = suffix;
  const std::vector<std::string> numbers =
      split(name.substr(begin.size(), name.size() - begin.size() - end.size()), '-');
  unsigned long number = 0;
  return numbers.size() == 2 && read_number(numbers[0], number) && read_number(numbers[1], number);
}

/// The hidden files of this process. Whoever makes, shows or removes one holds the mutex.
struct Hidden {
  std::mutex mutex;
  std::set<fs::path> paths;
  unsigned count = 0;
};

Hidden& hidden() {
  static Hidden files;
  return files;
}

/// Locks a new file; false if it was taken for abandoned, and removed, before it had its lock.
bool locked(int file) {
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  struct stat facts {};  // a file system without locks has no one that removes files by them
  return ::fstat(file, &facts) == 0 && facts.st_nlink > 0;
}

}  // namespace

void make_folder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure || !fs::is_directory(folder))
    throw Error(ExitCode::output, "cannot make the folder " + in_quotes(folder.string()) +
                                      (failure ? ": " + failure.message() : ""));
}

WrittenFolder::WrittenFolder(const fs::path& folder) {
  std::error_code failure;
  for (fs::path at = folder; !at.empty() && !fs::exists(at, failure); at = at.parent_path())
    made_.push_back(at);
  make_folder(folder);
  lock_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(lock_);
  throw Error(ExitCode::output, "another process writes into " + in_quotes(folder.string()) +
                                    "; give it a folder of its own");
}

WrittenFolder::~WrittenFolder() {
  std::error_code failure;
  for (const fs::path& folder : made_) fs::remove(folder, failure);
  if (lock_ >= 0) ::close(lock_);
}

HiddenFile::HiddenFile(const fs::path& target) : target_(followed(target)) {
  if (const std::string input = InputProtection::input_at(target_); !input.empty())
    throw Error(ExitCode::usage, in_quotes(target.string()) + " is the input " + in_quotes(input) +
                                     ", which it would replace; give another name");
  const std::lock_guard guard(hidden().mutex);
  // The process id keeps two processes apart and the counter two threads; O_EXCL decides where a
  // process of another machine has the same.
  while (true) {
    path_ = directory_of(target_) /
            (prefix + std::to_string(getpid()) + "-" + std::to_string(hidden().count++) + suffix);
    lock_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (lock_ >= 0 && locked(lock_)) break;
    if (lock_ < 0 && errno != EEXIST) fail(errno);
    if (lock_ >= 0) ::close(lock_);
  }
  hidden().paths.insert(path_);
}

HiddenFile::~HiddenFile() {
  const std::lock_guard guard(hidden().mutex);
  if (hidden().paths.erase(path_)) ::unlink(path_.c_str());
  ::close(lock_);
}

int HiddenFile::open() const {
  const int file = ::fcntl(lock_, F_DUPFD_CLOEXEC, 0);
  if (file < 0) fail(errno);
  return file;
}

void HiddenFile::show() {
  const std::lock_guard guard(hidden().mutex);
  struct stat old {};
  if (::stat(target_.c_str(), &old) == 0) ::fchmod(lock_, old.st_mode & 0777);
  if (::rename(path_.c_str(), target_.c_str()) != 0) fail(errno);
  InputProtection::except(lock_);
  hidden().paths.erase(path_);
}

void remove_hidden_files() {
  hidden().mutex.lock();  // and never unlocks it
  for (const fs::path& path : hidden().paths) ::unlink(path.c_str());
}

void remove_abandoned_files(const fs::path& folder) {
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, unreadable)) {
    if (!is_hidden_name(entry.path().filename().string())) continue;
    // a pipe of that name, without O_NONBLOCK, would be waited for
    const int file = ::open(entry.path().c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOFOLLOW);
    struct stat facts {};
    if (file < 0) continue;
    if (::fstat(file, &facts) == 0 && S_ISREG(facts.st_mode) && facts.st_uid == ::geteuid() &&
        ::flock(file, LOCK_EX | LOCK_NB) == 0)
      ::unlink(entry.path().c_str());
    ::close(file);
  }
}

}  // namespace psivox
