#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>

#include "psivox/error.h"

namespace psivox {

/// How a message about a file begins, and about one of its grids unless that is "".
inline std::string subject(const std::string& path, std::string_view grid = {}) {
  return path + ": " + (grid.empty() ? "" : "grid '" + std::string(grid) + "' ");
}

/// A message where its subject is known.
inline std::string without_subject(const std::string& message, const std::string& path,
                                   std::string_view grid) {
  for (const std::string& start : {subject(path, grid), subject(path)})
    if (message.starts_with(start)) return message.substr(start.size());
  return message;
}

/// What a file or folder that is no .vdb holds, and a line of Python or a command that makes psivox
/// draw it, as a sentence without its subject; empty if the format is not known. `head`: the file's
/// first bytes, which count before its name does.
std::string foreign_format(const std::string& path, std::string_view head = {});

/// Time and size of a file, which tell that it was written again; empty if there is none.
std::string file_stamp(const std::filesystem::path& path);

/// A run of a file's bytes in memory.
struct FileRun {
  std::int64_t begin = 0;  ///< its place in the file [bytes]
  std::int64_t size = 0;   ///< 0 behind the file's end
  std::shared_ptr<const char[]> bytes;

  std::int64_t end() const { return begin + size; }
  bool has(std::int64_t position) const { return position >= begin && position < end(); }
};

/// An open file that is read in blocks. The last 16 MiB of them stay in memory: what looks for a
/// grid's leaves and what unpacks them read each block once.
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

  /// The file's size when it was opened [bytes].
  std::int64_t size() const { return size_; }

  /// The block that has the position. Throws std::runtime_error if the system cannot read.
  FileRun run(std::int64_t position);

  /// Reads these bytes, fewer where the file ends, and does not keep them. Throws as `run` does.
  FileRun read(std::int64_t begin, std::int64_t size) const;

 private:
  std::string path_;
  std::int64_t size_ = 0;
  int file_ = -1;

  std::mutex mutex_;                       ///< of what follows
  std::map<std::int64_t, FileRun> runs_;   ///< by their begin
  std::deque<std::int64_t> oldest_first_;  ///< begins of the runs
};

/// The buffer of a stream over a file's bytes. OpenVDB skips parts of each leaf by a seek, which
/// throws a std::filebuf's buffer away. Here a seek within a run of bytes moves a pointer.
class FileBuffer final : public std::streambuf {
 public:
  /// The file must live as long.
  explicit FileBuffer(FileBlocks& file, Progress progress = {});

  FileBlocks& file() const { return file_; }

  /// The next `bytes` are what `progress` receives the fraction of.
  void expect(std::int64_t bytes);

  /// Tells progress that what was expected has come to this place [bytes].
  void report(std::int64_t reached);

  /// From now on reads so many bytes wherever the stream is beside the last ones, and keeps them
  /// for no other reader. 0: blocks that are kept, as at first.
  void read_only(std::int64_t bytes) { only_ = bytes; }

 protected:
  int_type underflow() override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override;

 private:
  std::int64_t position() const { return begin_ + (gptr() - eback()); }

  FileBlocks& file_;
  Progress progress_;
  std::int64_t expected_from_ = 0, expected_ = 0;  // [bytes]
  std::int64_t reported_ = 0;                      ///< how far progress has come [bytes]
  FileRun run_;                                    ///< the last one
  std::int64_t begin_ = 0;                         ///< of what is between eback and egptr
  std::int64_t only_ = 0;                          ///< see read_only
};

}  // namespace psivox
