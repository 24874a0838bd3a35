#pragma once

#include <filesystem>

namespace psivox::image_io {

/// The two file formats of a picture.
enum class Format { exr, png };

/// The format that a file of this name is written in; the extension's case does not matter.
/// Throws Error(usage) for any other extension.
Format format_from_extension(const std::filesystem::path& path);

/// The format of an existing file by its first bytes. A picture keeps working under another name,
/// and a hostile file meets only the two readers that psivox tests, not OpenImageIO's thirty.
/// Throws Error(input).
Format format_from_contents(const std::filesystem::path& path);

}  // namespace psivox::image_io
