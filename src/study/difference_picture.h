#pragma once

#include "psivox/image.h"

namespace psivox {

/// The difference a - b as an opaque picture. Of R, G and B it shows the channel with the largest
/// difference: blue below 0, red above, full colour from `scale` on.
Image difference_picture(const Image& a, const Image& b, double scale);

/// The picture at most `width` pixels wide: means over blocks of pixels.
Image shrunk(const Image& image, int width);

}  // namespace psivox
