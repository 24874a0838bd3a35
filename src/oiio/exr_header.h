#pragma once

#include <filesystem>

namespace psivox::image_io {

/// Throws Error(input) if an attribute of an EXR's header says that it is longer than the file.
/// OpenEXR would allocate that much.
void check_exr_header(const std::filesystem::path& path);

}  // namespace psivox::image_io
