#pragma once

#include "image/picture_files.h"

namespace psivox::image_io {

// The entries of PictureFiles, each in a file of its own name.
Image read_picture(const std::filesystem::path& path, Format format);
std::map<std::string, std::string> read_picture_metadata(const std::filesystem::path& path,
                                                         Format format);
void write_picture(const Image& image, Format format, const WriteOptions& options,
                   OutputFile& file);

}  // namespace psivox::image_io
