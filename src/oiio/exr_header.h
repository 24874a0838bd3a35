#pragma once

#include <filesystem>

namespace psivox::image_io {

/// Throws Error(input) if an attribute of an EXR's header is longer than the file or has another
/// length than a value of its type. OpenEXR would allocate the first, and reads values by their
/// types, so that it would take the rest of the second for attributes.
void check_exr_header(const std::filesystem::path& path);

}  // namespace psivox::image_io
