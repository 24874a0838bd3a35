#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace psivox::image_io {

/// What a 16-bit float can hold.
constexpr float largest_half = 65504;

/// What an .hdr is written with: RGBE ends at 2^127.
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
/// The same. Throws Error(usage) for an extension that no writer knows.
Format format_from_extension(const std::filesystem::path& path);

/// The format of an existing file by its first bytes. A picture keeps working under another name,
/// and a hostile file meets only the readers that psivox tests, not OpenImageIO's thirty.
/// Throws Error(input).
Format format_from_contents(const std::filesystem::path& path);

}  // namespace psivox::image_io
