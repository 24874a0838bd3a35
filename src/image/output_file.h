#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace psivox::image_io {

/// A file that appears under its name whole or not at all.
///
/// It is written under a hidden name in the target's directory, so that the rename stays on one
/// file system and is atomic. A failed call is remembered and told by commit().
class OutputFile {
 public:
  /// Creates the hidden file. Throws Error(output) if the target could not be written.
  explicit OutputFile(const std::filesystem::path& target);
  /// Removes the hidden file unless commit() was reached.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where the next bytes go.
  std::int64_t tell() const { return ftello(file_); }
  void seek(std::int64_t offset);
  void write(std::string_view bytes);

  /// Gives the file its name, replacing another. Throws Error(output) if that, or any call before,
  /// failed.
  void commit();

 private:
  void remember_failure();

  std::filesystem::path named_;   ///< as the user wrote it, for messages
  std::filesystem::path target_;  ///< symbolic links followed: the link is kept, not replaced
  std::filesystem::path hidden_;
  std::FILE* file_ = nullptr;
  int failure_ = 0;  ///< errno of the first failed call
};

}  // namespace psivox::image_io
