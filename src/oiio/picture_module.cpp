#include "oiio/picture_module.h"

#include <OpenImageIO/imageio.h>

namespace psivox::image_io {
namespace {

bool writes(Format format) {
  return OIIO::ImageOutput::create(facts_of(format).openimageio) != nullptr;
}

/// Of the library that runs, not of the header.
std::string version() {
  const int number = OIIO::openimageio_version();  // major * 10000 + minor * 100 + patch
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
         std::to_string(number % 100);
}

constexpr PictureFiles table = {read_picture, read_picture_metadata, writes, write_picture,
                                version};

}  // namespace
}  // namespace psivox::image_io

extern "C" const psivox::image_io::PictureFiles* psivox_picture_files() {
  return &psivox::image_io::table;
}
