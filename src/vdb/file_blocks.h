#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace psivox::vdb {

/// A run of a file's bytes in memory.
struct FileRun {
  std::int64_t begin = 0;  ///< its place in the file [bytes]
  std::int64_t size = 0;   ///< 0 behind the file's end
  std::shared_ptr<const char[]> bytes;

  std::int64_t end() const { return begin + size; }
  bool has(std::int64_t position) const { return position >= begin && position < end(); }
};

/// An open file that is read in large runs, each of them once: the last 64 MiB (see keep_at_most)
/// stay in memory, so that neither a second grid nor a second thread reads them again.
///
/// It copies by pread and does not map the file. A mapped file that another program makes shorter
/// ends this one by SIGBUS, and over a network it is read page by page, without errors.
///
/// Its functions may be called from several threads.
class FileBlocks {
 public:
  /// Throws Error(input) if the file cannot be opened or is none.
  explicit FileBlocks(const std::filesystem::path& path);

  /// Takes over a regular file that is open, as its descriptor. Throws Error(input) if it is none.
  /// The path is for messages.
  FileBlocks(std::string path, int descriptor);
  ~FileBlocks();
  FileBlocks(const FileBlocks&) = delete;
  FileBlocks& operator=(const FileBlocks&) = delete;

  const std::string& path() const { return path_; }

  /// For another process to read from.
  int descriptor() const { return file_; }

  /// Of the file when it was opened [bytes].
  std::int64_t size() const { return size_; }

  /// The run that has the position. If the file must be read for it, about `wanted` bytes are.
  /// Throws std::runtime_error if the system cannot read.
  FileRun run(std::int64_t position, std::int64_t wanted);

  /// Reads these bytes, fewer where the file ends, and does not keep them. Throws as `run` does.
  FileRun read(std::int64_t begin, std::int64_t size) const;

  /// Keeps no more than these bytes from now on, apart from the last run.
  void keep_at_most(std::int64_t bytes);

  /// Asks the system to begin reading what will be needed soon.
  void announce(std::int64_t begin, std::int64_t length) const;

 private:
  /// What to read for a position that is in no run: whole blocks, up to the next run.
  FileRun missing(std::int64_t position, std::int64_t wanted) const;
  const FileRun* find(std::int64_t position) const;
  void keep(const FileRun& run);
  void forget();  ///< the oldest runs, beyond what is kept

  std::string path_;
  std::int64_t size_ = 0;
  int file_ = -1;

  std::mutex mutex_;                       ///< of what follows
  std::map<std::int64_t, FileRun> runs_;   ///< by their begin
  std::deque<std::int64_t> oldest_first_;  ///< begins of the runs
  std::int64_t kept_ = 0;                  ///< size of the runs [bytes]
  std::int64_t most_kept_ = 64 << 20;      ///< [bytes]
};

}  // namespace psivox::vdb
