#pragma once

#include <filesystem>
#include <string>

#include "format.h"
#include "output_file.h"
#include "psivox/error.h"
#include "psivox/image.h"

namespace psivox::image_io {

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
