#include "picture_size.h"

#include <algorithm>
#include <string>

#include "error_text.h"

namespace psivox::image_io {

void check_size(const std::filesystem::path& path, int width, int height, double stored,
                int channels) {
  constexpr double most_values = 0x1p31;  // 8 GiB of floats, 16384x16384 pixels of 8 channels
  // A file that lacks stored pixels fails when they are read. The empty part of an EXR's display
  // window takes no byte of the file: it may be 1024 times what is stored, or a megapixel.
  const double shown = double(width) * height;
  const int most_channels = channels + 3;  // grey becomes R G B A
  if (width > 0 && height > 0 && shown <= 0x1p20 + 1024 * stored &&
      std::max(stored, shown) * most_channels <= most_values)
    return;
  throw read_error(path, "its header is damaged or asks for too much: " + std::to_string(width) +
                             "x" + std::to_string(height) + " pixels, " + std::to_string(channels) +
                             " channels");
}

}  // namespace psivox::image_io
