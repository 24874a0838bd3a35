#include <OpenImageIO/imageio.h>

#include <string>

#include "psivox/image.h"

namespace psivox {

std::string openimageio_version() {
  // major * 10000 + minor * 100 + patch, of the library that runs, not of the header.
  const int version = OIIO::openimageio_version();
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

}  // namespace psivox
