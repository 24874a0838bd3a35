#pragma once

#include "image/encode.h"

namespace psivox::oiio {

/// What image_io::write_exr and write_png do.
void write_exr(const Image& image, const WriteOptions& options, image_io::OutputFile& file);
void write_png(const Image& image, image_io::OutputFile& file);

}  // namespace psivox::oiio
