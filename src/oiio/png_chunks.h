#pragma once

#include <filesystem>

namespace psivox::image_io {

/// Throws Error(input) if a PNG is cut short or one of its checksums is wrong. libpng would find it
/// too, but it prints a line of its own, and OpenImageIO leaks memory when libpng jumps out of it.
void check_png_chunks(const std::filesystem::path& path);

}  // namespace psivox::image_io
