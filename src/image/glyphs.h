#pragma once

#include <string_view>
#include <vector>

namespace psivox::image_io {

/// One line of text as coverage, 0 to 1, row by row from the top.
struct TextPicture {
  int width = 0, height = 0;
  std::vector<float> coverage;
};

/// The text in DejaVu Sans, which the library contains, so that a machine needs no fonts. All
/// pictures of one size have the same height and baseline.
///
/// `size`: from the top of ascenders to the bottom of descenders [pixels].
TextPicture text_picture(std::string_view text, double size);

}  // namespace psivox::image_io
