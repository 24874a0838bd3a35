#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/text_file.h"
#include "format.h"
#include "output_file.h"
#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox::image_io {

/// A file that appears under its name whole or not at all.
///
/// It is written under a hidden name in the target's directory, so that the rename stays on one
/// file system and is atomic. Encoders write through it rather than to a name: some lose errors of
/// the last bytes (OpenEXR writes its offset table in a destructor that swallows exceptions),
/// whereas every failed call is remembered here and told by commit(). What goes to the standard
/// output is written to a temporary file first, and copied when it is complete.
class OutputFile {
 public:
  /// Creates the hidden file. Throws Error(output) if the target could not be written.
  explicit OutputFile(const std::filesystem::path& target);
  /// Removes what was written unless commit() was reached.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where the next bytes go.
  std::int64_t tell() const { return ftello(file_); }
  /// False where it cannot be.
  bool seek(std::int64_t offset);
  /// Bytes that were written.
  std::size_t write(std::string_view bytes);

  /// Gives the file its name, replacing another. Throws Error(output) if that, or any call before,
  /// failed, or who encoded the picture did; `library_says` is added where the system gave no
  /// reason.
  void commit(bool library_succeeded, const std::string& library_says);

 private:
  void remember_failure();
  void copy_to_standard_output();

  std::filesystem::path named_;  ///< as the user wrote it, for messages
  /// Symbolic links followed: the link is kept, not replaced. Empty: the standard output.
  std::filesystem::path target_;
  std::optional<HiddenFile> hidden_;  ///< unset: the standard output
  std::FILE* file_ = nullptr;
  int failure_ = 0;  ///< errno of the first failed call
};

/// The name of a channel in an EXR file: `R` in the picture, `depth` for the only channel of the
/// layer `depth`, `normal.X` in a layer of several.
std::string exr_channel_name(const Layer& layer, std::size_t channel);

/// Writes one part with zip: the channels of the picture, then the channels of each layer. Throws
/// Error(output).
void write_exr(const Image& image, const WriteOptions& options, OutputFile& file);

/// Reads linear, premultiplied R G B A, and all texts as metadata. Throws Error(input).
Image read_png(const std::filesystem::path& path);

/// The bytes of the file that write_png writes. Throws Error(output).
std::string png_bytes(const Image& image, const WriteOptions& options = {});
/// Writes the picture's srgb_codes. A PNG holds no other layers. Throws Error(output).
void write_png(const Image& image, const WriteOptions& options, OutputFile& file);

/// What the module psivox_oiio (src/oiio) offers. It is a module of its own because linking
/// OpenImageIO and all that it depends on takes longer than a small picture: it is loaded when a
/// picture is read that is no PNG, or written that is neither EXR nor PNG.
struct PictureFiles {
  /// Without `needs_picture` an EXR may have layers alone.
  Image (*read)(const std::filesystem::path& path, Format format, bool needs_picture);
  std::map<std::string, std::string> (*read_metadata)(const std::filesystem::path& path,
                                                      Format format);
  /// Whether this OpenImageIO can write the format.
  bool (*writes)(Format format);
  void (*write)(const Image& image, Format format, const WriteOptions& options, OutputFile& file);
  OcioView (*complete_view)(const OcioView& view);
  void (*show_by)(const OcioView& view, std::span<float> rgb);
  std::string (*version)();
};

/// Loads the module once. Throws an Error of this code if it cannot be loaded.
const PictureFiles& picture_files(ExitCode if_missing);

/// The module's one symbol.
inline constexpr const char* picture_files_symbol = "psivox_picture_files";
using GetPictureFiles = const PictureFiles* (*)();

}  // namespace psivox::image_io
