#pragma once

#include "output_file.h"
#include "psivox/image.h"

namespace psivox::image_io {

/// The name of a channel in an EXR file: `R` in the picture, `depth` for the only channel of the
/// layer `depth`, `normal.X` in a layer of several.
std::string exr_channel_name(const Layer& layer, std::size_t channel);

/// One part, zip; the picture's channels first, then those of each layer. Throws Error(output).
void write_exr(const Image& image, const WriteOptions& options, OutputFile& file);

/// 8-bit sRGB of the picture; other layers have no place in a PNG. Throws Error(output).
///
/// Colour is divided by alpha, cut to [0, 1], then encoded; alpha is kept, linear. Hence radiance
/// above alpha (a glow without opacity) is cut to alpha, and lost where alpha is 0: raising alpha
/// instead would save it over black, but make a glow hide what is behind it. EXR keeps it.
/// NaN becomes 0.
void write_png(const Image& image, OutputFile& file);

}  // namespace psivox::image_io
