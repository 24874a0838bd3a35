#pragma once

#include <zlib.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/text.h"
#include "scan/scan.h"

// The bytes of a scan's file, its values, and the headers of its formats.

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
  /// Passes over the rest of what is packed, behind which its checksum is. Throws Error(input) if
  /// that is wrong or missing.
  void check_rest();

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

/// The values of a scan in the file's order, as floats.
class ValueStream {
 public:
  /// Begins before the first value. Header and file must live as long.
  ValueStream(const Header& header, FileBlocks& file);

  /// Number of the next value.
  std::int64_t position() const { return position_; }

  /// These throw Error(input) if the file ends before, or holds no numbers.
  void pass_over(std::int64_t values);
  void read(std::span<float> to);

 private:
  double next_number();                          ///< of a text
  void read_bytes(char* to, std::int64_t size);  ///< decoded; of another encoding than text

  const Header& header_;
  ByteStream bytes_;
  std::string buffer_;
  std::int64_t position_ = 0;
};

/// Whether a file, unpacked if it is a gzip, begins as the header of NIfTI-1, NIfTI-2 or Analyze
/// 7.5, in either byte order.
bool is_nifti(std::string_view head);
/// Whether a file begins as the header of an NRRD.
bool is_nrrd(std::string_view head);

/// Read the header of a file that begins so. They throw Error(input) if psivox does not read what
/// the file has, or a number is impossible. A size may still be a lie: see Scan. Sources: nifti1.h
/// and nifti2.h (nifti.nimh.nih.gov), teem.sourceforge.net/nrrd/format.html.
Header read_nifti(FileBlocks& file, bool packed);
Header read_nrrd(FileBlocks& file);
/// The file that has an NRRD's values, as its header names it; empty: the header's own.
std::string nrrd_data_file(FileBlocks& file);

}  // namespace psivox::scan
