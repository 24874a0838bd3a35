#pragma once

#include "psivox/image.h"

namespace psivox {

/// a - b in colours of the map coolwarm: of R, G and B the difference that is largest, blue below
/// and red above 0, full colour from `scale` on. Opaque.
Image difference_picture(const Image& a, const Image& b, double scale);

/// The picture at most `width` pixels wide: means over blocks of pixels.
Image shrunk(const Image& image, int width);

}  // namespace psivox
