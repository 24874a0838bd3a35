#pragma once

#include <filesystem>

namespace psivox::image_io {

/// Throws Error(input) for a picture of a size that only a damaged or hostile header asks for.
/// Called before the pixels are allocated.
///
/// `width`, `height`: of the picture; `stored`: the number of pixels in the file.
void check_size(const std::filesystem::path& path, int width, int height, double stored,
                int channels);

}  // namespace psivox::image_io
