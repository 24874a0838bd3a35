#pragma once

#include <filesystem>
#include <string>

#include "psivox/image.h"

namespace psivox::image_io {

/// What the module psivox_oiio (src/oiio) offers. It stands in a module of its own because linking
/// OpenImageIO with all that it depends on takes longer than a small picture: who reads one loads
/// it.
struct PictureFiles {
  Image (*read_image)(const std::filesystem::path& path);
  std::string (*read_metadata)(const std::filesystem::path& path, const std::string& key);
  std::string (*version)();
};

/// The module's one symbol.
inline constexpr const char* picture_files_symbol = "psivox_picture_files";
using GetPictureFiles = const PictureFiles* (*)();

}  // namespace psivox::image_io
