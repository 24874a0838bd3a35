#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image/output_file.h"

namespace psivox::image_io {

// The entries of PictureFiles.
Image read_picture(const std::filesystem::path& path, Format format, bool needs_picture);
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

/// A layer to read, and the places of its channels in the file.
struct LayerSource {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::optional<std::size_t>> indices;  ///< none: the channel is 1 everywhere
};

/// Sorts a file's channels into layers, the inverse of exr_channel_name. The picture comes first,
/// from R G B or from the grey Y, with alpha 1 if there is no A. Channels with one prefix
/// (`normal.X`, `normal.Y`) are one layer. `has_picture` tells whether the file has one.
std::vector<LayerSource> layers_from_channels(const std::vector<std::string>& names,
                                              bool& has_picture);

/// Throws Error(input) if an attribute of an EXR's header is longer than the file or has another
/// length than a value of its type. OpenEXR would allocate the first, and reads values by their
/// types, so that it would take the rest of the second for attributes.
void check_exr_header(const std::filesystem::path& path);

}  // namespace psivox::image_io
