#pragma once

#include <filesystem>
#include <string>

#include "psivox/image.h"

namespace psivox::image_io {

/// What the module psivox_oiio (src/oiio) offers. It stands in a module of its own because linking
/// OpenImageIO with all that it depends on takes longer than a small picture, which is written
/// without it: only who reads a picture loads it.
struct PictureReader {
  Image (*read_image)(const std::filesystem::path& path);
  std::string (*read_metadata)(const std::filesystem::path& path, const std::string& key);
  std::string (*version)();
};

/// The module's one symbol.
inline constexpr const char* picture_reader_symbol = "psivox_picture_reader";
using GetPictureReader = const PictureReader* (*)();

}  // namespace psivox::image_io
