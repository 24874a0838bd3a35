#pragma once

#include <zlib.h>

#include <cstdint>
#include <memory>
#include <string>

#include "base/file_blocks.h"
#include "base/text.h"

namespace psivox::scan {

/// Throws Error(input) about the file.
[[noreturn]] void refuse(const FileBlocks& file, const std::string& what);

/// The number that a text is. Throws Error(input) with the field if it is none.
template <typename Number>
Number number(const FileBlocks& file, const std::string& text, const char* field) {
  Number value{};
  // std::from_chars knows no plus sign
  const std::string_view digits = std::string_view(text).substr(text.starts_with('+') ? 1 : 0);
  if (!read_number(digits, value))
    refuse(file, std::string(field) + " of " + in_quotes(text) + " is no number");
  return value;
}

/// A file's bytes from a place on, in their order; unpacked, if they are a gzip.
class ByteStream {
 public:
  /// The file must live as long.
  ByteStream(FileBlocks& file, std::int64_t begin, bool packed = false);
  ~ByteStream();
  ByteStream(const ByteStream&) = delete;
  ByteStream& operator=(const ByteStream&) = delete;

  const FileBlocks& file() const { return file_; }

  /// Bytes that were read or passed over.
  std::int64_t position() const { return position_; }

  /// Reads bytes, fewer where they end. Throws Error(input) if a gzip is damaged or the system
  /// cannot read.
  std::int64_t read(char* to, std::int64_t size);

  /// Reads them all, or throws Error(input): the file ends too early.
  void read_all(char* to, std::int64_t size);
  void pass_over(std::int64_t size);
  /// Returns the number of bytes up to the end.
  std::int64_t pass_over_rest();

  /// The next byte, as an unsigned char; -1 at the end.
  int next();

  /// The next line without its end (LF, CR LF, or that of the bytes). Throws Error(input) if it is
  /// longer than 64 KiB.
  std::string line();

 private:
  bool fill();      ///< makes the next bytes ready; false at the end
  bool unpack();    ///< the same of a gzip
  bool read_run();  ///< the next one of the file; false at its end

  FileBlocks& file_;
  std::int64_t in_file_;  ///< where to read next
  std::int64_t position_ = 0;
  FileRun run_;                                  ///< of the file
  const char *here_ = nullptr, *end_ = nullptr;  ///< bytes that are ready
  std::unique_ptr<z_stream> packed_;             ///< null: the bytes are not packed
  std::unique_ptr<char[]> unpacked_;
  bool ended_ = false;  ///< the gzip
};

}  // namespace psivox::scan
