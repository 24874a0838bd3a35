#pragma once

#include <OpenImageIO/filesystem.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

namespace psivox::image_io {

/// A file that appears under its name whole or not at all.
///
/// It is written under a hidden name in the target's directory, so that the rename stays on one
/// file system and is atomic. OpenImageIO writes through it rather than to a name: its writers lose
/// some errors of the last bytes (OpenEXR writes its offset table in a destructor that swallows
/// exceptions), whereas every failed call is remembered here.
class OutputFile final : public OIIO::Filesystem::IOProxy {
 public:
  /// Creates the hidden file. Throws Error(output) if the target could not be written.
  explicit OutputFile(const std::filesystem::path& target);
  /// Removes the hidden file unless commit() was reached.
  ~OutputFile() override;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Gives the file its name, replacing another. Throws Error(output) if that, or any write before,
  /// failed; `library_says` is added where the system gave no reason.
  void commit(bool library_succeeded, const std::string& library_says);

  const char* proxytype() const override { return "psivox"; }
  std::int64_t tell() override;
  bool seek(std::int64_t offset) override;
  std::size_t write(const void* bytes, std::size_t size) override;

 private:
  void remember_failure();

  std::filesystem::path named_;   ///< as the user wrote it, for messages
  std::filesystem::path target_;  ///< symbolic links followed: the link is kept, not replaced
  std::filesystem::path hidden_;
  std::FILE* file_ = nullptr;
  int failure_ = 0;  ///< errno of the first failed call
};

}  // namespace psivox::image_io
