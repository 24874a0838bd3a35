#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "psivox/image.h"

namespace psivox::image_io {

/// A file's pixels, all channels of one together.
struct StoredPixels {
  std::int64_t width = 0, height = 0;
  std::vector<std::string> channels;  ///< their names
  std::span<const float> values;
};

/// A picture's rectangle, in the coordinates of the stored pixels. 64 bits: an EXR's windows may
/// lie 2^31 apart.
struct Window {
  std::int64_t x = 0, y = 0;
  int width = 0, height = 0;
};

/// Whether the channels have a picture: R G B, or the grey Y.
bool have_picture(const std::vector<std::string>& channels);

/// Sorts a file's channels into layers, the inverse of exr_channel_name. The picture comes first,
/// if there is one, with alpha 1 if there is no A. Channels with one prefix (`normal.X`,
/// `normal.Y`) are one layer. Pixels of the window that the file does not store are 0.
std::vector<Layer> layers_of_file(const StoredPixels& stored, const Window& window);

}  // namespace psivox::image_io
