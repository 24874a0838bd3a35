#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace psivox {

/// Reads the whole file; `-` is the standard input. Throws Error(input): "cannot read WHAT 'PATH':
/// why".
std::string read_text(const std::string& path, const std::string& what);

/// Writes `text` to a file beside `path` and renames it. Writes directly to anything that is not a
/// regular file (a pipe, /dev/stdout). `-` is the standard output. Throws Error(output).
void write_text(const std::string& path, const std::string& text);

/// Throws Error(output) if write_text could not begin.
void check_text_writable(const std::string& path);

/// A new file under a hidden name beside its target. It gets the target's name when it is complete,
/// so that the target appears whole or not at all. Its lock tells others that its writer lives.
class HiddenFile {
 public:
  /// Creates the file. A symbolic link stays; its own target, which may be missing, is what is
  /// written. Throws std::system_error, and Error(usage) where InputProtection holds the target.
  explicit HiddenFile(const std::filesystem::path& target);
  /// Removes the file, unless it has got its name.
  ~HiddenFile();
  HiddenFile(const HiddenFile&) = delete;
  HiddenFile& operator=(const HiddenFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// Another descriptor of the file for writing, which the caller closes. Throws
  /// std::system_error.
  int open() const;
  /// Gives it the target's name, replacing another file. Throws std::system_error.
  void show();

 private:
  std::filesystem::path target_, path_;
  int lock_ = -1;  ///< a descriptor that holds the lock
};

/// Makes the folder and its parents. Throws Error(output).
void make_folder(const std::filesystem::path& folder);

/// A folder that one process writes at a time, where the file system has locks. It is made if it is
/// missing, with those above it.
class WrittenFolder {
 public:
  /// Throws Error(output) if it cannot be made, or if another WrittenFolder has it, of this process
  /// or another one.
  explicit WrittenFolder(const std::filesystem::path& folder);
  /// Removes the folders that it made and that are still empty.
  ~WrittenFolder();
  WrittenFolder(const WrittenFolder&) = delete;
  WrittenFolder& operator=(const WrittenFolder&) = delete;

 private:
  std::vector<std::filesystem::path> made_;  ///< from the inside out
  int lock_ = -1;                            ///< a descriptor that holds the lock, or -1
};

/// Removes all hidden files of this process and blocks every further one: for a process that is
/// about to end. It must not be called by a signal handler.
void remove_hidden_files();

/// Removes a folder's hidden files whose writers have ended without removing them, as by SIGKILL.
void remove_abandoned_files(const std::filesystem::path& folder);

}  // namespace psivox
