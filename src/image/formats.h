#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox::image_io {

/// `text` without line breaks: libraries report several lines, an Error has one.
std::string one_line(std::string text);

/// "cannot read 'path': why", Error(input).
Error read_error(const std::filesystem::path& path, const std::string& why);

/// The same for a file whose channels hold no picture.
Error no_picture(const std::filesystem::path& path, const std::vector<std::string>& channels);

/// "cannot write 'path': why", Error(output).
Error write_error(const std::filesystem::path& path, const std::string& why);

constexpr float largest_half = 65504;

/// The largest value written to an .hdr: RGBE ends at 2^127.
constexpr float largest_rgbe = 0x1p126f;

enum class Format { exr, png, tiff, jpeg, hdr, webp };

/// What psivox knows of a file format.
struct FormatFacts {
  Format format;
  std::string_view extension;
  std::string_view other_extension;  ///< that means the same; may be empty
  /// OpenImageIO's name of its reader and writer; null: psivox calls the format's own library.
  const char* openimageio;
  bool alpha;       ///< whether pictures are written with alpha
  int most_pixels;  ///< on a side, that the format or its encoder takes
};

const FormatFacts& facts_of(Format format);

/// The format that a file of this name is written in, if any; the extension's case does not matter.
std::optional<Format> format_of_extension(const std::filesystem::path& path);
/// The format by the extension. Throws Error(usage) if no writer knows it.
Format format_from_extension(const std::filesystem::path& path);

/// The format of an existing file by its first bytes. A picture keeps working under another name,
/// and a hostile file meets only the readers that psivox tests, not OpenImageIO's thirty.
/// Throws Error(input).
Format format_from_contents(const std::filesystem::path& path);

/// Throws Error(input) for a picture of a size that only a damaged or hostile header asks for.
/// Called before the pixels are allocated.
///
/// `width`, `height`: of the picture; `stored`: the number of pixels in the file.
void check_size(const std::filesystem::path& path, int width, int height, double stored,
                int channels);

/// Throws Error(output) where a picture's file would be refused.
void check_target(const std::filesystem::path& target);
/// Writes a picture's file, whole or not at all. Encoders make its bytes in memory, but for EXR's:
/// some lose errors of the last bytes that they write. Throws Error(output).
void write_bytes(const std::filesystem::path& target, const std::string& bytes);

/// The name of a channel in an EXR file: `R` in the picture, `depth` for the only channel of the
/// layer `depth`, `normal.X` in a layer of several.
std::string exr_channel_name(const Layer& layer, std::size_t channel);

/// A file's pixels, all channels of one together.
struct StoredPixels {
  std::int64_t width = 0, height = 0;
  std::vector<std::string> channels;  ///< their names
  std::span<const float> values;
};

/// A picture's rectangle, in the coordinates of the stored pixels. 64 bits: an EXR's windows may
/// lie 2^31 apart.
struct Window {
  std::int64_t x = 0, y = 0;
  int width = 0, height = 0;
};

/// Whether the channels have a picture: R G B, or the grey Y.
bool have_picture(const std::vector<std::string>& channels);

/// Sorts a file's channels into layers, the inverse of exr_channel_name. The picture comes first,
/// if there is one, with alpha 1 if there is no A. Channels with one prefix (`normal.X`,
/// `normal.Y`) are one layer. Pixels of the window that the file does not store are 0.
std::vector<Layer> layers_of_file(const StoredPixels& stored, const Window& window);

/// Writes one part with zip: the channels of the picture, then those of each layer. Throws
/// Error(output).
void write_exr(const Image& image, const WriteOptions& options,
               const std::filesystem::path& target);

/// Lets OpenEXR use all processors from now on, if a picture has many pixels.
void use_exr_threads(std::int64_t pixels);

/// Reads the first part. Without `needs_picture` it may have layers alone. Throws Error(input).
Image read_exr(const std::filesystem::path& path, bool needs_picture);

/// All texts of its header. Throws Error(input).
std::map<std::string, std::string> read_exr_metadata(const std::filesystem::path& path);
/// The same, but throws also if the file ends before its pixels do, of a deep picture before the
/// last lines' numbers of samples.
std::map<std::string, std::string> metadata_of_whole_exr(const std::filesystem::path& path);

/// Reads linear, premultiplied R G B A, and all texts as metadata. Throws Error(input).
Image read_png(const std::filesystem::path& path);

/// The bytes of a file with the picture's srgb_codes. A PNG holds no other layers. Throws
/// Error(output).
std::string png_bytes(const Image& image, const WriteOptions& options = {});

/// What the module psivox_oiio (src/oiio) offers. It is a module of its own because linking
/// OpenImageIO and all that it depends on takes longer than a small picture: it is loaded for the
/// formats that need it.
struct PictureFiles {
  Image (*read)(const std::filesystem::path& path, Format format);
  std::map<std::string, std::string> (*read_metadata)(const std::filesystem::path& path,
                                                      Format format);
  /// Whether this OpenImageIO can write the format.
  bool (*writes)(Format format);
  /// The bytes of the picture's file. Throws Error(output).
  std::string (*bytes)(const Image& image, Format format, const WriteOptions& options);
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
