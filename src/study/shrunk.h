#pragma once

#include "psivox/image.h"

namespace psivox {

/// The picture at most `width` pixels wide: means over blocks of pixels.
Image shrunk(const Image& image, int width);

}  // namespace psivox
