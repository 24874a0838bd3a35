#pragma once

#include <cstdint>
#include <streambuf>

#include "file_blocks.h"
#include "psivox/progress.h"

namespace psivox::vdb {

/// The buffer of a stream over a file's bytes. OpenVDB skips parts of each leaf by a seek, which
/// throws a std::filebuf's buffer away. Here a seek within a run of bytes moves a pointer.
class FileBuffer final : public std::streambuf {
 public:
  /// The file must live as long.
  explicit FileBuffer(FileBlocks& file, Progress progress = {});

  FileBlocks& file() const { return file_; }

  /// The next `bytes` are what `progress` receives the fraction of.
  void expect(std::int64_t bytes);

  /// From now on reads so many bytes wherever the stream is beside the last ones, and keeps them
  /// for no other reader. 0: larger runs that are kept, as at first.
  void read_only(std::int64_t bytes) { only_ = bytes; }

  /// Reads ahead of the stream's position, from the last run of bytes up to `end`.
  void read_to(std::int64_t end);

 protected:
  int_type underflow() override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode mode) override;

 private:
  std::int64_t position() const { return begin_ + (gptr() - eback()); }
  bool fetch(std::int64_t position);  ///< into run_; false behind the file's end
  void report(std::int64_t reached);

  FileBlocks& file_;
  Progress progress_;
  std::int64_t expected_from_ = 0, expected_ = 0;  // [bytes]
  std::int64_t reported_ = 0;                      ///< how far progress has come [bytes]
  FileRun run_;                                    ///< the last one
  std::int64_t begin_ = 0;                         ///< of what is between eback and egptr
  std::int64_t wanted_;                            ///< how much to read at a time [bytes]
  std::int64_t only_ = 0;                          ///< see read_only
};

}  // namespace psivox::vdb
