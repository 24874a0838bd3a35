#pragma once

#include "output_file.h"
#include "psivox/image.h"

namespace psivox::image_io {

/// The name of a channel in an EXR file: `R` in the picture, `depth` for the only channel of the
/// layer `depth`, `normal.X` in a layer of several.
std::string exr_channel_name(const Layer& layer, std::size_t channel);

/// One part, zip; the picture's channels first, then those of each layer. Throws Error(output).
void write_exr(const Image& image, const WriteOptions& options, OutputFile& file);

/// The picture's srgb_codes; other layers have no place in a PNG. Throws Error(output).
void write_png(const Image& image, const WriteOptions& options, OutputFile& file);

}  // namespace psivox::image_io
