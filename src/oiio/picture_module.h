#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "image/formats.h"

namespace psivox::image_io {

// The entries of PictureFiles.
Image read_picture(const std::filesystem::path& path, Format format);
std::map<std::string, std::string> read_picture_metadata(const std::filesystem::path& path,
                                                         Format format);
void write_picture(const Image& image, Format format, const WriteOptions& options,
                   OutputFile& file);

OcioView complete_ocio_view(const OcioView& view);
void show_by_ocio(const OcioView& view, std::span<float> rgb);

/// TIFF and JPEG have a fixed set of tags: psivox's metadata goes into these. HDR and WebP files
/// hold none, as OpenImageIO writes them.
struct Tag {
  const char* key;   ///< of Image::metadata
  const char* name;  ///< OpenImageIO's
};
inline constexpr Tag tags[] = {{"psivox:scene", "ImageDescription"},
                               {"psivox:renderer", "Model"},
                               {"psivox:folder", "DocumentName"}};

/// `Software` is this and psivox:version, which tells that the other tags are psivox's.
inline constexpr std::string_view software = "psivox ";

/// Longer texts are left out. A JPEG's segment ends at 65533 bytes, beyond which libjpeg ends the
/// program, and OpenImageIO adds some of its own; it reads a TIFF's text up to 65536.
inline constexpr std::size_t longest_text = 60000;

}  // namespace psivox::image_io
