#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "psivox/error.h"

namespace psivox::image_io {

/// `text` without line breaks: libraries report several lines, an Error has one.
std::string one_line(const std::string& text);

/// "cannot read 'path': why", Error(input).
Error read_error(const std::filesystem::path& path, const std::string& why);

/// "cannot write 'path': why", Error(output).
Error write_error(const std::filesystem::path& path, const std::string& why);

/// The largest 16-bit float.
constexpr float largest_half = 65504;

/// The largest value written to an .hdr: RGBE ends at 2^127.
constexpr float largest_rgbe = 0x1p126f;

enum class Format { exr, png, tiff, jpeg, hdr, webp };

/// What psivox knows of a file format.
struct FormatFacts {
  Format format;
  std::string_view extension;
  std::string_view other_extension;  ///< that means the same; may be empty
  const char* openimageio;           ///< OpenImageIO's name of its reader and writer
  bool alpha;                        ///< whether pictures are written with alpha
  int most_pixels;                   ///< on a side, that the format or its encoder takes
};

const FormatFacts& facts_of(Format format);

/// Whether a file of this name goes to the standard output: `-` as PNG, `exr:-` as EXR, and so on.
bool is_standard_output(const std::filesystem::path& path);

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

}  // namespace psivox::image_io
