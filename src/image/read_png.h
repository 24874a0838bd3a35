#pragma once

#include <filesystem>

#include "psivox/image.h"

namespace psivox::image_io {

/// Any kind of PNG as linear, premultiplied R G B A, with its texts as metadata. Throws
/// Error(input), also where one checksum is wrong.
Image read_png(const std::filesystem::path& path);

}  // namespace psivox::image_io
